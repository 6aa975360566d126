/* `berth-target --check`: what this machine is fit for, and what to do about the rest. */
#ifndef HAL_LINUX_PREFLIGHT_H
#define HAL_LINUX_PREFLIGHT_H

#include <string>

#include "../rig/rig.h"

namespace berth
{

enum class verdict { fine, warning, missing };

struct finding {
    berth::verdict verdict;
    std::string subject;
    std::string text;
    std::string remedy; /* what to do; empty if it is fine */
};

/* Of sched_rt_runtime_us and sched_rt_period_us, as the kernel writes them. */
finding judge_throttling(const std::string &runtime_us, const std::string &period_us);

/* Of the list of CPUs that are kept free, and the one that the loop is bound to; negative: none. */
finding judge_isolation(const std::string &isolated, std::int64_t cpu);

/* Of the CPUs that serve the interface's interrupts; empty: it has none of its own. */
finding judge_interrupt(const std::string &interface, const std::string &cpus, std::int64_t cpu);

/* Of a controller that is up, by what it says of errors on the bus. */
finding judge_bus_errors(const std::string &interface, const std::string &state);

/* Prints one line a finding. False: something is missing without which the loop cannot move the robot. */
bool print_preflight(const rig &rig);

} // namespace berth

#endif
