/* `berth-target --check`: what this machine is fit for, and what to do about the rest. */
#ifndef HAL_LINUX_PREFLIGHT_H
#define HAL_LINUX_PREFLIGHT_H

#include <string>
#include <vector>

#include "../rig/rig.h"
#include "can_link.h"
#include "lines.h"

namespace berth
{

enum class verdict { fine, warning, missing };

struct finding {
    berth::verdict verdict;
    std::string subject;
    std::string text;
    std::string remedy; /* what to do; empty if it is fine */
};

/* How much time the kernel gives to others before real-time threads: sched_rt_runtime_us, and from Linux 6.12 on the
 * fair server of each CPU. `root` stands before /proc and /sys, empty on a machine; `release` is the kernel's, as
 * "6.12.0-rt1"; `cpu` is the loop's, negative: any. */
std::vector<finding> judge_throttling(const std::string &root, const std::string &release, std::int64_t cpu);

/* Of the list of CPUs that are kept free, and the one that the loop is bound to; negative: none. */
finding judge_isolation(const std::string &isolated, std::int64_t cpu);

/* Of the CPUs that serve the interface's interrupts; empty: it has none of its own. */
finding judge_interrupt(const std::string &interface, const std::string &cpus, std::int64_t cpu);

/* Of an interface that is there: the commands that bring it up at this bit rate, from any state that it may be in.
 */
std::string bus_remedy(const std::string &interface, const can_link &link, long long bit_rate_bit_per_s);

/* Of a controller's way back from bus-off. */
finding judge_restart(const std::string &interface, const can_link &link);

/* Of the line of this key and name: `called` are those that go by it. */
finding judge_line(const std::string &key, const std::string &name, const std::vector<seen_line> &called);

/* Of a controller that is up, by what it says of errors on the bus. */
finding judge_bus_errors(const std::string &interface, const std::string &state);

/* Of the address to which live samples go; a loop runs without it as well. */
finding judge_live(const std::string &address);

/* Prints one line a finding. `live_address`: empty where no samples are sent. False: something is missing without
 * which the loop cannot move the robot. */
bool print_preflight(const rig &rig, const std::string &live_address);

} // namespace berth

#endif
