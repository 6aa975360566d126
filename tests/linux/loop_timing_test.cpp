/* Histograms against a sorted list of the same times. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "../../hal/linux/loop_timing.h"
#include "../../sim_hal/hil/random.h"
#include "../../sim_hal/hil/wake_histogram.h"
#include "../support/files.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

loop_timing three_wakes()
{
    loop_timing timing;
    for (const std::int64_t ns : {3400, 3900, 8000}) {
        timing.wake_up.add(ns);
    }
    timing.execution.add(25000);
    timing.overruns = 2;
    return timing;
}

} // namespace

TEST_CASE("timing: percentiles are those of the sorted times, to the bin of 1 us")
{
    REPRODUCIBLE();
    random_stream random(test_seed(), 7);
    time_histogram histogram;
    std::vector<double> times_us;
    for (int i = 0; i < 20000; i++) {
        const double time_us = std::exp(4.0 + random.normal());
        histogram.add(static_cast<std::int64_t>(1e3 * time_us));
        times_us.push_back(time_us);
    }
    std::sort(times_us.begin(), times_us.end());
    for (const double share : {0.5, 0.99, 0.999, 0.9999, 1.0}) {
        CAPTURE(share);
        const auto rank = static_cast<std::size_t>(std::ceil(share * 20000.0)) - 1;
        CHECK(histogram.percentile_us(share) >= times_us[rank] - 0.001);
        CHECK(histogram.percentile_us(share) <= times_us[rank] + 1.0);
    }
    CHECK(histogram.max_us() == doctest::Approx(times_us.back()).epsilon(1e-4));
    CHECK(histogram.min_us() == doctest::Approx(times_us.front()).epsilon(1e-2));
}

TEST_CASE("timing: a time beyond the bins counts, and is the maximum")
{
    time_histogram histogram;
    histogram.add(1500);
    histogram.add(50000000);
    CHECK(histogram.count() == 2);
    CHECK(histogram.max_us() == 50000.0);
    CHECK(histogram.percentile_us(0.5) == 2.0);
    CHECK(histogram.percentile_us(0.99) == 50000.0);
}

TEST_CASE("timing: every time is in the bins, one below 0 in the first")
{
    time_histogram histogram;
    for (const std::int64_t ns : {-2500, -1, 1500, 2500}) {
        histogram.add(ns);
    }
    CHECK(histogram.counts()[0] == 2);
    CHECK(histogram.min_us() == -2.5);
    CHECK(histogram.percentile_us(0.5) == 1.0);
    CHECK(histogram.percentile_us(0.75) == 2.0);
}

TEST_CASE("timing: the file has cyclictest's layout, and is one that `berth map --jitter` reads")
{
    const temporary_folder folder;
    const std::string path = folder / "jitter.json";
    write_timing(path, three_wakes(), {"program rig", "SCHED_FIFO 80", 1, 80, 2500, "then"});
    const nlohmann::json file = nlohmann::json::parse(read_bytes(path));
    CHECK(file["file_version"] == 1);
    CHECK(file["num_threads"] == 1);
    CHECK(file["resolution_in_ns"] == 0);
    CHECK(file["sysinfo"]["sysname"] == "Linux");
    const nlohmann::json &thread = file["thread"]["0"];
    CHECK(thread["histogram"] == nlohmann::json{{"3", 2}, {"8", 1}});
    CHECK(thread["cycles"] == 3);
    CHECK(thread["min"] == 3);
    CHECK(thread["max"] == 8);
    CHECK(thread["cpu"] == 1);
    CHECK(file["berth"]["overruns"] == 2);
    CHECK(file["berth"]["execution"]["max_us"] == 25.0);

    const wake_histogram wakes = parse_wake_histogram(read_bytes(path), path);
    CHECK(wakes.wakes == 3.0);
    CHECK(wakes.max_ns() == 8000);
}

} // namespace berth
