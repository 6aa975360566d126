/* A signal that is longer than its samples, against the whole of it. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <memory>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/motion.h"
#include "../../sim_hal/thinned_signal.h"

namespace berth
{

namespace
{

constexpr std::size_t samples_max = 8;

/* What a thinned signal should hold of values[0 .. count). */
std::vector<double> thinned(const std::vector<double> &values, std::size_t stride, thinning how)
{
    std::vector<double> found;
    for (std::size_t at = 0; at + stride <= values.size(); at += stride) {
        const auto from = values.begin() + static_cast<std::ptrdiff_t>(at);
        const auto to = from + static_cast<std::ptrdiff_t>(stride);
        found.push_back(how == thinning::first ? *from : *std::max_element(from, to));
    }
    return found;
}

} // namespace

TEST_CASE("thinned signal: a power of two of ticks to a sample, never too many, and the same as of the whole signal")
{
    for (const thinning how : {thinning::first, thinning::largest}) {
        thinned_signal signal(how, samples_max);
        std::vector<double> whole;
        for (int tick = 0; tick < 1000; tick++) {
            const double value = std::sin(1.7 * tick) * tick;
            whole.push_back(value);
            signal.add(value);
            CAPTURE(tick);
            REQUIRE(signal.added() == whole.size());
            REQUIRE(signal.values().size() <= samples_max);
            REQUIRE(signal.values().size() >= std::min(whole.size(), samples_max / 2));
            REQUIRE(signal.values() == thinned(whole, signal.stride(), how));
        }
        signal.clear();
        signal.add(3.0);
        CHECK(signal.values() == std::vector<double>{3.0});
        CHECK(signal.stride() == 1);
    }
}

TEST_CASE("motion: a run of hours is kept in as much memory as one of minutes, and says the same")
{
    constexpr double growth_per_s = -1e-4;
    constexpr double frequency_Hz = 0.93;
    const rig rig = load_rig("ess");
    const double period_s = 1.0 / rig.firmware.loop.rate_Hz;
    for (const std::int64_t ticks : {std::int64_t{1000000}, std::int64_t{5000000}}) {
        const auto recorder = std::make_unique<motion_recorder>(rig);
        tick_record record{};
        record.state = SUPERVISOR_RUNNING;
        for (record.index = 0; record.index < ticks; record.index++) {
            const double now_s = period_s * static_cast<double>(record.index);
            record.manipulator_position_m =
                0.01 * std::exp(growth_per_s * now_s) * std::cos(6.283185307179586 * frequency_Hz * now_s);
            recorder->note_tick(record, false, {});
        }
        const motion_evidence found = recorder->conclude();
        CHECK(recorder->longest().position_m.size() <= kept_ticks_max);
        REQUIRE(found.growth);
        CHECK(found.growth->growth_per_s == doctest::Approx(growth_per_s).epsilon(0.01));
        CHECK(found.growth->frequency_Hz == doctest::Approx(frequency_Hz).epsilon(1e-3));
        CHECK(found.running_s == doctest::Approx(period_s * static_cast<double>(ticks)));
        CHECK(found.trend == motion_trend::unknown);
    }
}

} // namespace berth
