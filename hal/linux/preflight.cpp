#include "preflight.h"

#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "can_link.h"
#include "lines.h"
#include "machine.h"
#include "real_time.h"

namespace berth
{

namespace
{

enum class verdict { fine, warning, missing };

struct finding {
    berth::verdict verdict;
    std::string subject;
    std::string text;
    std::string remedy; /* what to do; empty if it is fine */
};

using findings = std::vector<finding>;

finding judge(bool is_fine, verdict otherwise, std::string subject, std::string text, std::string remedy)
{
    return {is_fine ? verdict::fine : otherwise, std::move(subject), std::move(text),
            is_fine ? "" : std::move(remedy)};
}

void check_kernel(findings &found)
{
    found.push_back(judge(has_realtime_kernel(), verdict::warning, "kernel",
                          kernel() + (has_realtime_kernel() ? "" : ": not PREEMPT_RT, wakes late by milliseconds"),
                          "install linux-image-rt-amd64 or linux-image-rt-arm64"));
    const std::string runtime_us = first_line_of("/proc/sys/kernel/sched_rt_runtime_us");
    found.push_back(
        judge(runtime_us == "-1", verdict::warning, "throttling",
              runtime_us == "-1" ? "off" : "real-time threads may run " + runtime_us + " us of every second",
              "sysctl kernel.sched_rt_runtime_us=-1"));
}

void check_cpu(const target_rig &target, findings &found)
{
    const std::string cpus = isolated_cpus();
    found.push_back(judge(!cpus.empty() && target.cpu >= 0, verdict::warning, "isolation",
                          (cpus.empty() ? "no CPU is isolated" : "isolated: " + cpus) +
                              (target.cpu < 0 ? "; the loop is bound to none"
                                              : "; the loop is bound to " + std::to_string(target.cpu)),
                          "boot with isolcpus=N nohz_full=N rcu_nocbs=N and set target.cpu = N"));
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
    const std::string cpus = interrupt_cpus(interface);
    if (!cpus.empty()) {
        const bool is_apart = target.cpu < 0 || !has_cpu(cpus, target.cpu);
        found.push_back(judge(is_apart, verdict::warning, interface + " interrupt", "served by CPU " + cpus,
                              "give it another CPU than the loop's: /proc/irq/N/smp_affinity_list"));
    }
    if (!link.is_virtual) {
        const std::string how = "ip link set " + interface + " type can restart-ms 100";
        found.push_back(judge(link.restart_ms > 0, verdict::warning, interface + " restart",
                              link.restart_ms > 0 ? std::to_string(link.restart_ms) + " ms after bus-off"
                                                  : "none: after bus-off it stays off the bus",
                              how + " (the loop itself stays in fault until it is reset)"));
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
    const auto wanted_bit_per_s = static_cast<long long>(rig.bus.bit_rate_bit_per_s);
    found.push_back(judge(is_usable, verdict::missing, interface, text,
                          "ip link set " + interface + " type can bitrate " + std::to_string(wanted_bit_per_s) +
                              " restart-ms 100 && ip link set " + interface + " up"));
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

struct seen_line {
    std::string chip;
    std::string name;
    bool is_used;
};

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

void check_lines(const target_rig &target, findings &found)
{
    std::vector<seen_line> seen;
    const int chips = gpio_for_each_line(
        [](void *context, const char *chip, const char *name, int is_used) {
            static_cast<std::vector<seen_line> *>(context)->push_back({chip, name, is_used != 0});
        },
        &seen);
    const std::size_t closed = closed_chips();
    found.push_back(judge(closed == 0, verdict::warning, "GPIO",
                          std::to_string(chips) + " chips with " + std::to_string(seen.size()) +
                              " lines, libgpiod " + gpio_library_version() +
                              (closed == 0 ? "" : "; " + std::to_string(closed) + " more may not be opened"),
                          "run as root, or let a udev rule give /dev/gpiochip* to your group"));
    for (const line_wiring &wiring : wiring_of(target)) {
        if (wiring.name.empty()) {
            found.push_back({verdict::warning, wiring.key, "not wired", ""});
            continue;
        }
        const auto line = std::find_if(seen.begin(), seen.end(), [&](const seen_line &one) {
            return one.name == wiring.name && (target.gpio_chip.empty() || target.gpio_chip == one.chip);
        });
        const bool is_there = line != seen.end();
        found.push_back(
            judge(is_there && !line->is_used, verdict::missing, wiring.key,
                  !is_there       ? "no line is called " + wiring.name
                  : line->is_used ? wiring.name + " on " + line->chip + " is held by another program"
                                  : wiring.name + " on " + line->chip,
                  is_there ? "stop that program" : "name a line that `gpioinfo` lists, or \"\" for none"));
    }
}

} // namespace

bool print_preflight(const rig &rig)
{
    findings found;
    check_kernel(found);
    check_cpu(rig.target, found);
    check_scheduling(rig.target, found);
    check_buses(rig, found);
    check_lines(rig.target, found);
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
