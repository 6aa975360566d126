#include "machine.h"

#include <sys/utsname.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "gpio_lines.h"

namespace berth
{

namespace
{

std::string or_none(const std::string &text)
{
    return text.empty() ? "none" : text;
}

} // namespace

std::string first_line_of(const std::string &path)
{
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    return line;
}

std::string kernel()
{
    utsname system{};
    uname(&system);
    return std::string(system.sysname) + " " + system.release + " " + system.version + " " + system.machine;
}

/* Several devices may share an interrupt: their names are the last words of its line, with commas between. */
std::vector<std::string> interrupts_of(const std::vector<std::string> &names, std::istream &interrupts)
{
    std::vector<std::string> numbers;
    std::string line;
    while (std::getline(interrupts, line)) {
        std::istringstream words(line);
        std::string number;
        words >> number;
        bool is_one = false;
        for (std::string word; words >> word;) {
            const std::string name = word.back() == ',' ? word.substr(0, word.size() - 1) : word;
            is_one |= std::find(names.begin(), names.end(), name) != names.end();
        }
        if (is_one) {
            numbers.push_back(number.substr(0, number.find(':')));
        }
    }
    return numbers;
}

/* Most drivers name it after the interface, those on SPI after their chip, as "spi0.0". */
std::string interrupt_cpus(const std::string &interface)
{
    std::error_code error;
    const auto device = std::filesystem::canonical("/sys/class/net/" + interface + "/device", error);
    std::vector<std::string> names = {interface};
    if (!error) {
        names.push_back(device.filename().string());
    }
    std::ifstream interrupts("/proc/interrupts");
    std::string cpus;
    for (const std::string &number : interrupts_of(names, interrupts)) {
        const std::string effective = first_line_of("/proc/irq/" + number + "/effective_affinity_list");
        const std::string one =
            effective.empty() ? first_line_of("/proc/irq/" + number + "/smp_affinity_list") : effective;
        cpus += (cpus.empty() ? "" : ",") + one;
    }
    return cpus;
}

bool has_cpu(const std::string &list, std::int64_t cpu)
{
    std::istringstream ranges(list);
    std::string range;
    while (std::getline(ranges, range, ',')) {
        std::istringstream ends(range);
        std::int64_t first = 0;
        std::int64_t last = 0;
        char dash = 0;
        if (ends >> first) {
            last = ends >> dash >> last ? last : first;
            if (cpu >= first && cpu <= last) {
                return true;
            }
        }
    }
    return false;
}

bool has_realtime_kernel()
{
    return first_line_of("/sys/kernel/realtime") == "1" || kernel().find("PREEMPT_RT") != std::string::npos;
}

std::string isolated_cpus()
{
    return first_line_of("/sys/devices/system/cpu/isolated");
}

std::string governor_of(std::int64_t cpu)
{
    return first_line_of("/sys/devices/system/cpu/cpu" + std::to_string(std::max<std::int64_t>(cpu, 0)) +
                         "/cpufreq/scaling_governor");
}

std::vector<std::pair<std::string, std::string>> facts_for_log(const target_rig &target)
{
    return {{"berth_kernel", kernel()},
            {"berth_kernel_realtime", has_realtime_kernel() ? "yes" : "no"},
            {"berth_isolated_cpus", or_none(isolated_cpus())},
            {"berth_governor", or_none(governor_of(target.cpu))},
            {"berth_libgpiod", gpio_library_version()}};
}

std::string command_line(int argc, char **argv)
{
    std::string line;
    for (int i = 0; i < argc; i++) {
        line += (i == 0 ? "" : " ") + std::string(argv[i]);
    }
    return line;
}

std::string date_now()
{
    char text[64] = "";
    const std::time_t now = std::time(nullptr);
    std::tm broken{};
    std::strftime(text, sizeof text, "%a, %d %b %Y %H:%M:%S %z", localtime_r(&now, &broken));
    return text;
}

} // namespace berth
