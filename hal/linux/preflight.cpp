#include "preflight.h"

#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "../rig/rig_file.h"
#include "can_link.h"
#include "lines.h"
#include "live_sender.h"
#include "machine.h"
#include "real_time.h"
#include "watchdog.h"

namespace berth
{

namespace
{

using findings = std::vector<finding>;

finding judge(bool is_fine, verdict otherwise, std::string subject, std::string text, std::string remedy)
{
    return {is_fine ? verdict::fine : otherwise, std::move(subject), std::move(text),
            is_fine ? "" : std::move(remedy)};
}

void check_kernel(const target_rig &target, findings &found)
{
    found.push_back(judge(has_realtime_kernel(), verdict::warning, "kernel",
                          kernel() + (has_realtime_kernel() ? "" : ": not PREEMPT_RT, wakes late by milliseconds"),
                          "install linux-image-rt-amd64 or linux-image-rt-arm64"));
    utsname system{};
    uname(&system);
    const findings throttling = judge_throttling("", system.release, target.cpu);
    found.insert(found.end(), throttling.begin(), throttling.end());
}

void check_cpu(const target_rig &target, findings &found)
{
    found.push_back(judge_isolation(isolated_cpus(), target.cpu));
    const std::string governor = governor_of(target.cpu);
    found.push_back(judge(governor.empty() || governor == "performance", verdict::warning, "governor",
                          governor.empty() ? "none: the frequency is fixed" : governor,
                          "cpupower frequency-set --governor performance"));
    found.push_back(judge(access("/dev/cpu_dma_latency", W_OK) == 0, verdict::warning, "CPU sleep",
                          access("/dev/cpu_dma_latency", W_OK) == 0
                              ? "/dev/cpu_dma_latency can be held at 0"
                              : "/dev/cpu_dma_latency cannot be written: deep sleep states delay the wake-up",
                          "run as root, or let a udev rule give it to your group"));
}

std::string limit_text(rlim_t limit)
{
    return limit == RLIM_INFINITY ? "unlimited" : std::to_string(limit);
}

void check_scheduling(const target_rig &target, findings &found)
{
    rlimit priority{};
    rlimit memory{};
    getrlimit(RLIMIT_RTPRIO, &priority);
    getrlimit(RLIMIT_MEMLOCK, &memory);
    found.push_back({verdict::fine, "limits",
                     "rtprio " + limit_text(priority.rlim_cur) + ", memlock " + limit_text(memory.rlim_cur) +
                         " bytes" + (geteuid() == 0 ? "; root is above them" : ""),
                     ""});
    const real_time tried(target);
    found.push_back({tried.is_real_time() ? verdict::fine : verdict::missing, "scheduling",
                     tried.is_real_time() ? tried.description() : tried.problem(),
                     tried.is_real_time() ? "" : "without it motion stays disabled (see --without-realtime)"});
}

void check_controller(const std::string &interface, const can_link &link, const target_rig &target, findings &found)
{
    if (!link.is_virtual) {
        found.push_back(judge_interrupt(interface, interrupt_cpus(interface), target.cpu));
        found.push_back(judge_restart(interface, link));
    }
}

void check_bus(const std::string &key, const std::string &interface, const rig &rig, findings &found)
{
    const std::optional<can_link> link = find_can_link(interface);
    if (!link || !link->is_can) {
        found.push_back({verdict::missing, interface, link ? "is no CAN interface" : "there is no such interface",
                         "see `ip link` and " + key});
        return;
    }
    const bool is_usable = link->is_up && link->state != "bus-off" && link->state != "stopped";
    std::string text = std::string(link->is_up ? "up" : "down");
    text += link->state.empty() ? "" : ", " + link->state;
    text += link->is_virtual ? ", virtual" : ", " + std::to_string(link->bit_rate_bit_per_s) + " bit/s";
    if (is_usable && !link->state.empty()) {
        found.push_back(judge_bus_errors(interface, link->state));
    }
    const auto wanted_bit_per_s = static_cast<long long>(rig.bus.bit_rate_bit_per_s);
    found.push_back(
        judge(is_usable, verdict::missing, interface, text, bus_remedy(interface, *link, wanted_bit_per_s)));
    if (!link->is_virtual && link->bit_rate_bit_per_s != static_cast<std::uint32_t>(wanted_bit_per_s)) {
        found.push_back(
            {verdict::warning, interface + " bit rate",
             std::to_string(link->bit_rate_bit_per_s) + " bit/s, the rig says " + std::to_string(wanted_bit_per_s),
             "make both the same: bus.bit_rate_bit_per_s"});
    }
    const std::uint32_t queue = link->transmit_queue_frames;
    found.push_back(judge(queue >= 4 && queue <= 100, verdict::warning, interface + " queue",
                          std::to_string(queue) + " frames" +
                              (queue > 100 ? ": setpoints would grow old in it"
                               : queue < 4 ? ": too few"
                                           : ""),
                          "ip link set " + interface + " txqueuelen 10"));
    found.push_back({verdict::fine, interface + " stamps",
                     has_hardware_stamps(interface) ? "hardware: the controller stamps received frames"
                                                    : "software: the kernel stamps received frames, after the "
                                                      "interrupt",
                     ""});
    check_controller(interface, *link, rig.target, found);
}

void check_buses(const rig &rig, findings &found)
{
    const int socket = ::socket(PF_CAN, SOCK_RAW, 0);
    if (socket < 0 && errno == EAFNOSUPPORT) {
        found.push_back({verdict::missing, "SocketCAN", "this kernel has none",
                         "modprobe can-raw, or use a kernel that has it"});
        return;
    }
    if (socket >= 0) {
        close(socket);
    }
    check_bus("target.robot_interface", rig.target.robot_interface, rig, found);
    check_bus("target.sensor_interface", rig.target.sensor_interface, rig, found);
}

/* Chips whose lines cannot even be listed, for want of a right. */
std::size_t closed_chips()
{
    std::size_t closed = 0;
    for (const auto &device : std::filesystem::directory_iterator("/dev")) {
        const bool is_chip = device.path().filename().string().rfind("gpiochip", 0) == 0;
        closed += is_chip && access(device.path().c_str(), R_OK | W_OK) != 0;
    }
    return closed;
}

/* None is opened: that would start it. */
void check_watchdog(const std::string &wanted, findings &found)
{
    const std::string device = is_any_watchdog(wanted) ? first_watchdog : wanted;
    const bool is_there = !device.empty() && access(device.c_str(), W_OK) == 0;
    const std::string shown = device.empty() ? "none" : is_there ? device : device + ": " + std::strerror(errno);
    if (device.empty()) {
        found.push_back(
            {verdict::warning, "watchdog", shown,
             "a machine that hangs is not restarted: target.watchdog_device = \"auto\" takes the board's"});
    } else if (is_any_watchdog(wanted)) {
        found.push_back(
            judge(is_there, verdict::warning, "watchdog", shown,
                  "a machine that hangs is not restarted: load the driver of the board's watchdog, and let "
                  "a udev rule give it to your group"));
    } else {
        found.push_back(judge(is_there, verdict::missing, "watchdog", shown,
                              "load its driver, and run as root or let a udev rule give it to your group; "
                              "target.watchdog_device = \"auto\" runs without one if there is none"));
    }
}

void check_lines(const target_rig &target, findings &found)
{
    const auto [chips, seen] = lines_of_machine();
    const std::size_t closed = closed_chips();
    found.push_back(judge(closed == 0, verdict::warning, "GPIO",
                          std::to_string(chips) + " chips with " + std::to_string(seen.size()) +
                              " lines, libgpiod " + gpio_library_version() +
                              (closed == 0 ? "" : "; " + std::to_string(closed) + " more may not be opened"),
                          "run as root, or let a udev rule give /dev/gpiochip* to your group"));
    for (const line_wiring &wiring : wiring_of(target)) {
        if (wiring.name.empty()) {
            found.push_back({verdict::warning, wiring.key, "not wired", "name the line if the rig has one"});
            continue;
        }
        found.push_back(judge_line(wiring.key, wiring.name, lines_called(seen, wiring.name, target.gpio_chip)));
    }
}

} // namespace

namespace
{

/* Of a release such as "6.12.0-rt1". */
bool is_at_least(const std::string &release, int major, int minor)
{
    char *end = nullptr;
    const long of_major = std::strtol(release.c_str(), &end, 10);
    const long of_minor = *end == '.' ? std::strtol(end + 1, nullptr, 10) : 0;
    return of_major > major || (of_major == major && of_minor >= minor);
}

/* The CPUs that have a fair server, as they are called under debugfs: that of the loop, or all. */
std::vector<std::string> served_cpus(const std::string &folder, std::int64_t cpu)
{
    std::vector<std::string> names;
    if (cpu >= 0) {
        names.push_back("cpu" + std::to_string(cpu));
        return names;
    }
    std::error_code error;
    for (const auto &entry : std::filesystem::directory_iterator(folder, error)) {
        names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
}

/* Ordinary tasks that starve are served for 50 ms of each second, if nobody changes that, by a deadline server that
 * comes before every SCHED_FIFO thread: kernel/sched/deadline.c of Linux 6.12. */
finding judge_fair_server(const std::string &root, std::int64_t cpu)
{
    const std::string folder = "/sys/kernel/debug/sched/fair_server/";
    std::string all;
    std::string remedy;
    bool is_known = false;
    for (const std::string &name : served_cpus(root + folder, cpu)) {
        std::string place = folder;
        place += name;
        const std::string runtime_ns = first_line_of(root + place + "/runtime");
        const std::string period_ns = first_line_of(root + place + "/period");
        is_known = is_known || !runtime_ns.empty();
        const double runtime_ms = 1e-6 * std::strtod(runtime_ns.c_str(), nullptr);
        if (runtime_ms > 0.0) {
            char text[120];
            std::snprintf(text, sizeof text, "%s%s: %g of every %g ms", all.empty() ? "" : ", ", name.c_str(),
                          runtime_ms, 1e-6 * std::strtod(period_ns.c_str(), nullptr));
            all += text;
            remedy += remedy.empty() ? "echo 0 > " : " && echo 0 > ";
            remedy += place;
            remedy += "/runtime";
        }
    }
    if (!is_known) {
        return {verdict::warning, "fair server",
                "could not be looked at: it may take 50 ms of every second from the loop (since Linux 6.12)",
                "mount -t debugfs none /sys/kernel/debug, and run --check as root"};
    }
    return judge(all.empty(), verdict::warning, "fair server",
                 all.empty() ? "off" : "ordinary tasks that starve come before real-time threads, " + all, remedy);
}

} // namespace

std::vector<finding> judge_throttling(const std::string &root, const std::string &release, std::int64_t cpu)
{
    const std::string runtime_us = first_line_of(root + "/proc/sys/kernel/sched_rt_runtime_us");
    const std::string period_us = first_line_of(root + "/proc/sys/kernel/sched_rt_period_us");
    const long long share_us = std::strtoll(runtime_us.c_str(), nullptr, 10);
    const bool is_off =
        runtime_us.empty() || share_us < 0 || share_us >= std::strtoll(period_us.c_str(), nullptr, 10);
    const std::string share = "real-time threads may run " + runtime_us + " of every " + period_us + " us";
    if (!is_at_least(release, 6, 12)) {
        return {judge(is_off, verdict::warning, "throttling", is_off ? "off" : share,
                      "sysctl kernel.sched_rt_runtime_us=-1")};
    }
    const std::string what_it_does = "since Linux 6.12 sched_rt_runtime_us bounds deadline tasks and groups of "
                                     "real-time threads, not the loop";
    return {{verdict::fine, "throttling",
             (is_off ? "off; " : runtime_us + " of every " + period_us + " us; ") + what_it_does, ""},
            judge_fair_server(root, cpu)};
}

/* The kernel changes bit rate and restart-ms of an interface only while it is down. */
std::string bus_remedy(const std::string &interface, const can_link &link, long long bit_rate_bit_per_s)
{
    return (link.is_up ? "ip link set " + interface + " down && " : "") + "ip link set " + interface +
           " type can bitrate " + std::to_string(bit_rate_bit_per_s) + " restart-ms 100 && ip link set " +
           interface + " up";
}

finding judge_restart(const std::string &interface, const can_link &link)
{
    const std::string set = "ip link set " + interface + " type can restart-ms 100";
    std::string remedy =
        link.is_up ? "ip link set " + interface + " down && " + set + " && ip link set " + interface + " up" : set;
    remedy += " (a driver that cannot, as of a serial-line adapter, says \"Operation not supported\": then only a "
              "person brings it back; the loop itself stays in fault until it is reset)";
    if (link.is_up && link.state == "bus-off") {
        remedy = "ip link set " + interface + " type can restart brings it back once; for ever: " + remedy;
    }
    return judge(link.restart_ms > 0, verdict::warning, interface + " restart",
                 link.restart_ms > 0 ? std::to_string(link.restart_ms) + " ms after bus-off"
                                     : "none: after bus-off it stays off the bus",
                 remedy);
}

finding judge_line(const std::string &key, const std::string &name, const std::vector<seen_line> &called)
{
    if (called.empty()) {
        return {verdict::missing, key, "no line is called " + name,
                "name a line that `gpioinfo` lists, or \"\" for none"};
    }
    const std::string ambiguous = that_is_ambiguous(called);
    if (!ambiguous.empty()) {
        const std::size_t end = ambiguous.find("; ");
        return {verdict::missing, key, ambiguous.substr(0, end), ambiguous.substr(end + 2)};
    }
    const std::string place = name + " on " + called.front().chip;
    return judge(!called.front().is_used, verdict::missing, key,
                 place + (called.front().is_used ? " is held by another program" : ""), "stop that program");
}

finding judge_isolation(const std::string &isolated, std::int64_t cpu)
{
    return judge(cpu >= 0 && has_cpu(isolated, cpu), verdict::warning, "isolation",
                 (isolated.empty() ? "no CPU is isolated" : "isolated: " + isolated) +
                     (cpu < 0 ? "; the loop is bound to none" : "; the loop is bound to " + std::to_string(cpu)),
                 "boot with isolcpus=N nohz_full=N rcu_nocbs=N and set target.cpu = N");
}

finding judge_interrupt(const std::string &interface, const std::string &cpus, std::int64_t cpu)
{
    return judge(cpu < 0 || (!cpus.empty() && !has_cpu(cpus, cpu)), verdict::warning, interface + " interrupt",
                 cpus.empty() ? "none of its own" : "served by CPU " + cpus,
                 "see that another CPU than the loop's serves it, or for USB its host's: /proc/interrupts, "
                 "/proc/irq/N/smp_affinity_list");
}

finding judge_bus_errors(const std::string &interface, const std::string &state)
{
    return judge(state == "error-active", verdict::warning, interface + " errors", state,
                 "look at wiring, termination and bit rate, and whether anybody else is on the bus");
}

finding judge_live(const std::string &address)
{
    try {
        const live_sender tried(address, {"", "", NS_PER_S, 0});
    } catch (const input_error &error) {
        return {verdict::missing, "live view", error.what(), "start without --live, or repair the network"};
    }
    return {verdict::fine, "live view", "samples go to " + address + "; nobody answers whether they arrive", ""};
}

bool print_preflight(const rig &rig, const std::string &live_address)
{
    findings found;
    check_kernel(rig.target, found);
    check_cpu(rig.target, found);
    check_scheduling(rig.target, found);
    check_buses(rig, found);
    check_lines(rig.target, found);
    check_watchdog(rig.target.watchdog_device, found);
    if (!live_address.empty()) {
        found.push_back(judge_live(live_address));
    }
    bool is_fit = true;
    for (const finding &one : found) {
        static const char *const words[] = {"ok", "WARNING", "MISSING"};
        std::printf("%-8s %-16s %s\n", words[static_cast<int>(one.verdict)], one.subject.c_str(), one.text.c_str());
        if (!one.remedy.empty()) {
            std::printf("%-8s %-16s -> %s\n", "", "", one.remedy.c_str());
        }
        is_fit &= one.verdict != verdict::missing;
    }
    std::printf("%s\n", is_fit ? "fit to move the robot" : "not fit to move the robot: see MISSING above");
    return is_fit;
}

} // namespace berth
