/* Whole ticks of the linear object against the same ticks step by step. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <utility>
#include <vector>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/diagnosis/replay/linear_ticks.h"

using namespace berth;

namespace
{

/* A robot that goes in corners, at the begin and at the end of each step. */
std::vector<double> wandering(std::size_t steps)
{
    std::vector<double> position_m{0.004};
    position_m.reserve(steps + 1);
    for (std::size_t i = 1; i <= steps; i++) {
        const double t = static_cast<double>(i);
        position_m.push_back(0.004 + 1e-3 * std::sin(0.013 * t) + 1e-5 * std::abs(std::sin(0.4 * t)));
    }
    return position_m;
}

/* Of the steps that end at those positions: every fifth has a corner. */
std::vector<double> corners(std::size_t positions)
{
    std::vector<double> bulge_m(positions, 0.0);
    for (std::size_t i = 1; i < positions; i += 5) {
        bulge_m[i] = 2e-6 * std::sin(0.7 * static_cast<double>(i));
    }
    return bulge_m;
}

/* Largest difference of the sampled force, and the largest force, N. `kept`: of the object's further force. */
template <std::size_t kept>
std::pair<double, double> compare(const rig &rig, int steps_min, bool has_corners)
{
    constexpr std::size_t ticks = 400;
    const double period_s = config_period_s(&rig.firmware);
    const tick_steps tick = divide_tick(rig, period_s, steps_min);
    const std::vector<double> position_m = wandering(ticks * tick.count());
    const std::vector<double> bulge_m =
        has_corners ? corners(position_m.size()) : std::vector<double>(position_m.size(), 0.0);
    object_steps object(rig);
    object.start(rig, position_m[0], 0.0);
    REQUIRE(object.is_linear());
    REQUIRE(object.has_further_force() == (kept > 0));
    std::vector<object_steps::step_maps> maps(tick.kinds);
    for (std::size_t step = 0; step < tick.count(); step++) {
        maps[tick.kind[step]] = object.make_maps(tick.duration_s[step]);
    }
    const linear_ticks<kept> whole(object, tick, maps);
    auto state = linear_ticks<kept>::at_rest(object);
    double difference_N = 0.0;
    double largest_N = 0.0;
    const double *at_m = position_m.data();
    const double *beside_m = bulge_m.data();
    for (std::size_t n = 0; n < ticks; n++) {
        const double by_ticks_N = whole.advance(state, at_m, has_corners ? beside_m + 1 : nullptr);
        double by_steps_N = 0.0;
        for (std::size_t step = 0; step < tick.count(); step++) {
            if (step == tick.sample_after) {
                by_steps_N = object.measured_N();
            }
            object.advance(maps[tick.kind[step]], tick.duration_s[step], {at_m[0], at_m[1], beside_m[1]}, 0.0);
            at_m++;
            beside_m++;
        }
        difference_N = std::max(difference_N, std::abs(by_ticks_N - by_steps_N));
        largest_N = std::max(largest_N, std::abs(by_steps_N));
    }
    return {difference_N, largest_N};
}

/* Wherever the knots and the sample fall in the tick, of few steps and of many. */
template <std::size_t kept>
void check_everywhere(const std::vector<std::string> &object)
{
    for (const char *const delay : {"sensor.delay_ms=2.5", "sensor.delay_ms=1.1", "sensor.delay_ms=6.4"}) {
        for (const char *const dead_time : {"robot.dead_time_ms=17.5", "robot.dead_time_ms=16.9"}) {
            for (const char *const order : {"sensor.low_pass_order=1", "sensor.low_pass_order=2"}) {
                for (const int variant : {0, 1, 2, 3}) {
                    const int steps_min = variant % 2 == 0 ? 1 : 8;
                    const bool has_corners = variant >= 2;
                    CAPTURE(delay);
                    CAPTURE(dead_time);
                    CAPTURE(order);
                    CAPTURE(steps_min);
                    CAPTURE(has_corners);
                    std::vector<std::string> settings = object;
                    settings.insert(settings.end(), {delay, dead_time, order});
                    const auto [difference_N, largest_N] =
                        compare<kept>(load_rig("ess", settings), steps_min, has_corners);
                    CHECK(largest_N > 1.0);
                    CHECK(difference_N < 1e-11 * largest_N);
                }
            }
        }
    }
}

} // namespace

TEST_CASE("linear object: whole ticks are their steps one after another, wherever the sample falls")
{
    check_everywhere<0>({});
}

TEST_CASE("linear object: so they are where it relaxes, quickly or slowly")
{
    for (const char *const time : {"object.relaxation_time_ms=0.5", "object.relaxation_time_ms=900"}) {
        CAPTURE(time);
        check_everywhere<linear_law::kept>({"object.relaxation_stiffness_N_per_m=1500", time});
    }
}

TEST_CASE("linear object: so they are with a second mode, also one that creeps or swings by itself for long")
{
    for (const char *const damping : {"object.second_damping_ratio=0", "object.second_damping_ratio=0.05",
                                      "object.second_damping_ratio=1", "object.second_damping_ratio=3"}) {
        for (const char *const frequency : {"object.second_frequency_Hz=0.4", "object.second_frequency_Hz=12"}) {
            CAPTURE(damping);
            CAPTURE(frequency);
            check_everywhere<linear_law::kept>({"object.second_mass_kg=15", frequency, damping});
        }
    }
}
