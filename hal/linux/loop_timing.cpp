#include "loop_timing.h"

#include <sys/utsname.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "../rig/rig_file.h"
#include "../version.h"
#include "machine.h"

namespace berth
{

namespace
{

using json = nlohmann::ordered_json;

json bins_of(const time_histogram &histogram)
{
    json bins = json::object();
    const std::vector<std::uint32_t> &counts = histogram.counts();
    for (std::size_t us = 0; us < counts.size(); us++) {
        if (counts[us] > 0) {
            bins[std::to_string(us)] = counts[us];
        }
    }
    return bins;
}

json summary_of(const time_histogram &histogram)
{
    return {{"count", histogram.count()},
            {"min_us", histogram.min_us()},
            {"avg_us", histogram.mean_us()},
            {"p50_us", histogram.percentile_us(0.5)},
            {"p99_us", histogram.percentile_us(0.99)},
            {"p99_9_us", histogram.percentile_us(0.999)},
            {"p99_99_us", histogram.percentile_us(0.9999)},
            {"max_us", histogram.max_us()},
            {"histogram", bins_of(histogram)}};
}

void print_line(const char *name, const time_histogram &histogram)
{
    std::printf("  %-13s", name);
    if (histogram.count() == 0) {
        std::printf(" not measured\n");
        return;
    }
    std::printf(" min %8.1f  avg %8.1f  p50 %6.0f  p99 %6.0f  p99.9 %6.0f  p99.99 %6.0f  max %8.1f us\n",
                histogram.min_us(), histogram.mean_us(), histogram.percentile_us(0.5), histogram.percentile_us(0.99),
                histogram.percentile_us(0.999), histogram.percentile_us(0.9999), histogram.max_us());
}

} // namespace

double time_histogram::percentile_us(double share) const
{
    const auto wanted = static_cast<std::uint64_t>(std::ceil(share * static_cast<double>(count_)));
    std::uint64_t below = 0;
    for (std::size_t us = 0; us < counts_.size(); us++) {
        below += counts_[us];
        if (below >= wanted) {
            return std::min(static_cast<double>(us + 1), max_us());
        }
    }
    return max_us();
}

void write_timing(const std::string &path, const loop_timing &timing, const timing_setting &setting)
{
    utsname system{};
    uname(&system);
    const time_histogram &wake_up = timing.wake_up;
    const json thread = {{"histogram", bins_of(wake_up)},
                         {"cycles", wake_up.count()},
                         {"min", std::lround(std::floor(wake_up.min_us()))},
                         {"max", std::lround(std::floor(wake_up.max_us()))},
                         {"avg", wake_up.mean_us()},
                         {"cpu", setting.cpu},
                         {"node", 0}};
    const json all = {{"file_version", 1},
                      {"cmdline", setting.command_line},
                      {"rt_test_version", version()},
                      {"start_time", setting.start_time},
                      {"end_time", date_now()},
                      {"return_code", 0},
                      {"sysinfo",
                       {{"sysname", system.sysname},
                        {"nodename", system.nodename},
                        {"release", system.release},
                        {"version", system.version},
                        {"machine", system.machine},
                        {"realtime", first_line_of("/sys/kernel/realtime") == "1" ? 1 : 0}}},
                      {"num_threads", 1},
                      {"resolution_in_ns", 0},
                      {"thread", {{"0", thread}}},
                      {"berth",
                       {{"real_time", setting.real_time},
                        {"priority", setting.priority},
                        {"interval_us", setting.interval_us},
                        {"overruns", timing.overruns},
                        {"wake_up", summary_of(timing.wake_up)},
                        {"execution", summary_of(timing.execution)},
                        {"tick_to_wire", summary_of(timing.tick_to_wire)},
                        {"force_age", summary_of(timing.force_age)}}}};
    std::ofstream file(path);
    file << all.dump(1) << "\n";
    if (!file.flush()) {
        throw input_error(path +
                          ": the histograms cannot be written; is the folder writable and the disk not full?");
    }
}

void print_timing(const loop_timing &timing)
{
    std::printf("timing: %llu ticks, %llu overruns\n", static_cast<unsigned long long>(timing.wake_up.count()),
                static_cast<unsigned long long>(timing.overruns));
    print_line("wake-up", timing.wake_up);
    print_line("execution", timing.execution);
    print_line("tick to wire", timing.tick_to_wire);
    print_line("force age", timing.force_age);
}

} // namespace berth
