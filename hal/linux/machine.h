/* Facts about the machine that the loop runs on: for the log, for --jitter and for --check. */
#ifndef HAL_LINUX_MACHINE_H
#define HAL_LINUX_MACHINE_H

#include <istream>
#include <string>
#include <utility>
#include <vector>

#include "../rig/rig.h"

namespace berth
{

/* First line of a file, without its end; empty if it cannot be read. */
std::string first_line_of(const std::string &path);

/* The numbers of the interrupts that have one of these names in the text of /proc/interrupts. */
std::vector<std::string> interrupts_of(const std::vector<std::string> &names, std::istream &interrupts);

/* The CPUs that serve the interrupts of a network interface or of the device behind it, as "0-2,5"; empty: it has
 * none of its own, as on USB. */
std::string interrupt_cpus(const std::string &interface);

/* A list of CPUs as the kernel writes it, "0-2,5", has this one. */
bool has_cpu(const std::string &list, std::int64_t cpu);

bool has_realtime_kernel();
std::string kernel();                      /* "Linux 6.1.0-rt-amd64 #1 SMP PREEMPT_RT ..." */
std::string isolated_cpus();               /* "2-3", or empty */
std::string governor_of(std::int64_t cpu); /* "performance", or empty where the kernel does not scale frequency */

/* Key and text of each, as they go into the log's header. */
std::vector<std::pair<std::string, std::string>> facts_for_log(const target_rig &target);

std::string command_line(int argc, char **argv);
std::string date_now();

} // namespace berth

#endif
