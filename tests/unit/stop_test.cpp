/* A stop is the shortest stop: it brakes as hard as the limits allow, in the direction of motion, and never
 * reverses. */
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "firmware/limits.h"
#include "seeded.h"
#include "tick_builder.h"

namespace
{

using bench::app_bench;

/* The shortest stop, tick by tick: positions from `position_m` on at which it brakes by a T each tick. */
std::vector<double> shortest_stop(double position_m, double velocity_m_per_s, double acceleration_m_per_s2,
                                  double period_s)
{
    std::vector<double> positions_m;
    const double change = acceleration_m_per_s2 * period_s;
    while (velocity_m_per_s != 0.0) {
        const double speed = std::fmax(0.0, std::fabs(velocity_m_per_s) - change);
        velocity_m_per_s = std::copysign(speed, velocity_m_per_s);
        position_m += velocity_m_per_s * period_s;
        positions_m.push_back(position_m);
        velocity_m_per_s = speed == 0.0 ? 0.0 : velocity_m_per_s;
    }
    return positions_m;
}

void check_is_shortest(const std::vector<double> &setpoints_m, double position_m, double velocity_m_per_s,
                       const app_config &config, double tolerance_m)
{
    const auto wanted_m =
        shortest_stop(position_m, velocity_m_per_s, config.limits.acceleration_m_per_s2, config_period_s(&config));
    REQUIRE(setpoints_m.size() >= wanted_m.size());
    double furthest_m = 0.0; /* in the direction of motion */
    double reversal_m = 0.0;
    double off_m = 0.0;
    for (std::size_t i = 0; i < setpoints_m.size(); i++) {
        const double expected_m = wanted_m.empty() ? position_m : wanted_m[std::min(i, wanted_m.size() - 1)];
        const double way_m = std::copysign(1.0, velocity_m_per_s) * (setpoints_m[i] - position_m);
        off_m = std::fmax(off_m, std::fabs(setpoints_m[i] - expected_m));
        reversal_m = std::fmax(reversal_m, furthest_m - way_m);
        furthest_m = std::fmax(furthest_m, way_m);
    }
    CHECK(off_m <= tolerance_m);
    CHECK(reversal_m <= tolerance_m);
}

struct stop_case {
    const char *name;
    std::function<void(app_bench &)> press;
};

const stop_case stops[] = {
    {"emergency stop", [](app_bench &b) { b.emergency_stop = 1; }},
    {"robot fault", [](app_bench &b) { b.robot_fault = true; }},
    {"sensor saturated", [](app_bench &b) { b.saturated = true; }},
    {"enable off", [](app_bench &b) { b.enable = 0; }},
    {"hold", [](app_bench &b) { b.request = OPERATOR_HOLD; }},
    {"end of the run", [](app_bench &b) { b.stop = 1; }},
};

/* A manipulator that nothing holds, on its way at `velocity_m_per_s`, with setpoints that have caught up. */
app_bench coasting(double velocity_m_per_s, double rate_Hz)
{
    app_config config = config_default();
    config.loop.rate_Hz = rate_Hz;
    config.limits = {-5.0, 5.0, 2.5, 50.0};
    config.manipulator.initial_velocity_m_per_s = velocity_m_per_s;
    app_bench bench(config);
    bench.request = OPERATOR_RUN;
    REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
    bench.run(static_cast<int>(0.5 * rate_Hz));
    REQUIRE(bench.state() == SUPERVISOR_RUNNING);
    REQUIRE(bench.app().limits.velocity_m_per_s == doctest::Approx(velocity_m_per_s));
    return bench;
}

} // namespace

TEST_CASE("stop: whatever stops the loop, the setpoints brake in the direction of motion and stay where they rest")
{
    constexpr double wire_step_m = 1e-11;
    for (const stop_case &stop : stops) {
        for (const double velocity_m_per_s : {2.0, -2.0, 0.7, -0.031}) {
            for (const double rate_Hz : {400.0, 1000.0}) {
                CAPTURE(std::string(stop.name));
                CAPTURE(velocity_m_per_s);
                CAPTURE(rate_Hz);
                app_bench bench = coasting(velocity_m_per_s, rate_Hz);
                const double position_m = bench.app().limits.position_m;
                const double speed_m_per_s = bench.app().limits.velocity_m_per_s;
                stop.press(bench);
                std::vector<double> setpoints_m;
                for (int i = 0; i < 100; i++) {
                    bench.tick();
                    REQUIRE(bench.state() != SUPERVISOR_RUNNING);
                    setpoints_m.push_back(bench.app().recorder.tick.command_position_m);
                }
                check_is_shortest(setpoints_m, position_m, speed_m_per_s, bench.app().config, 2.0 * wire_step_m);
            }
        }
    }
}

TEST_CASE("stop: at 2 m/s and 50 m/s2 it takes 40 ms")
{
    app_bench bench = coasting(2.0, 400.0);
    const double pressed_m = bench.app().recorder.tick.command_position_m;
    bench.emergency_stop = 1;
    bench.run(16);
    CHECK(limits_at_rest(&bench.app().limits) != 0);
    CHECK(bench.app().recorder.tick.command_position_m - pressed_m == doctest::Approx(0.0375));
}

TEST_CASE("stop: from any motion, also one that fell behind its target, it is the shortest one")
{
    SEEDED(random, "stop:*");
    for (int run = 0; run < 1000; run++) {
        CAPTURE(run);
        app_config config = config_default();
        config.limits.velocity_m_per_s = seeded::log_uniform(random, 1e-2, 10.0);
        config.limits.acceleration_m_per_s2 = seeded::log_uniform(random, 1e-1, 1e3);
        limits limits;
        limits_start(&limits, &config);
        const double target_m = seeded::uniform(random, -1.0, 1.0);
        const auto ticks = random() % 400;
        for (std::uint64_t i = 0; i < ticks; i++) {
            limits_step(&limits, target_m);
        }
        const double position_m = limits.position_m;
        const double velocity_m_per_s = limits.velocity_m_per_s;
        const double rest_m = limits_stop(&limits);
        std::vector<double> setpoints_m;
        for (int i = 0; i < 2000 && !limits_at_rest(&limits); i++) {
            setpoints_m.push_back(limits_step(&limits, rest_m));
        }
        setpoints_m.push_back(limits_step(&limits, rest_m));
        check_is_shortest(setpoints_m, position_m, velocity_m_per_s, config, 1e-9);
        CHECK(limits_step(&limits, rest_m) == rest_m);
    }
}
