/* A robot's free clock against what its drift and phase say by themselves. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/diagnosis/replay/robot_reference.h"
#include "../../sim_hal/diagnosis/samples/clock_slips.h"
#include "../../sim_hal/diagnosis/samples/clock_ways.h"
#include "../../sim_hal/diagnosis/samples/slip_table.h"

using namespace berth;

namespace
{

constexpr double period_s = 0.0025;
constexpr double dead_time_s = 0.0175;

rig with_clock(double drift_ppm, double phase_ms)
{
    rig made = load_rig("ess", {});
    made.robot.clock = robot_clock::free;
    made.robot.clock_drift_ppm = drift_ppm;
    made.robot.clock_phase_ms = phase_ms;
    made.robot.dead_time_ms = 1e3 * dead_time_s;
    return made;
}

record record_of(double duration_s)
{
    record made;
    made.period_s = period_s;
    const auto rows = static_cast<std::size_t>(duration_s / period_s);
    for (std::size_t n = 0; n < rows; n++) {
        made.time_s.push_back(period_s * static_cast<double>(n));
    }
    made.segments = {{0, rows}};
    return made;
}

} // namespace

TEST_CASE("clock: it slips whenever drift and phase have made a whole period")
{
    const record data = record_of(40.0);
    for (const double drift_ppm : {200.0, -200.0, 37.0}) {
        CAPTURE(drift_ppm);
        const double phase_ms = 0.7;
        const double arrival_s = setpoint_arrival_s(with_clock(drift_ppm, phase_ms));
        std::vector<double> expected;
        for (int whole = -10; whole <= 10; whole++) {
            const double time_s = (whole * period_s + arrival_s - 1e-3 * phase_ms) / (1e-6 * drift_ppm);
            if (time_s > 0.0 && time_s < data.time_s.back()) {
                expected.push_back(time_s);
            }
        }
        std::vector<double> told = slip_times_s(with_clock(drift_ppm, phase_ms), data);
        std::sort(told.begin(), told.end());
        std::sort(expected.begin(), expected.end());
        REQUIRE(told.size() == expected.size());
        for (std::size_t i = 0; i < told.size(); i++) {
            CHECK(told[i] == doctest::Approx(expected[i]));
        }
    }
    CHECK(slip_times_s(with_clock(10.0, 0.7), data).empty());
}

TEST_CASE("clock: a turn leaves a single slip where it is, and the mean lateness")
{
    const record data = record_of(15.0);
    fit_result fitted;
    fitted.rig = with_clock(150.0, 1.2);
    fitted.parameters = {{find_key("robot.dead_time_ms"), 10.0, 25.0}};
    const clock_ways ways(fitted, data);
    REQUIRE(ways.has_slips);
    rig turned = fitted.rig;
    ways.turn(turned, 9.0);
    CHECK(turned.robot.clock_drift_ppm == doctest::Approx(159.0));
    CHECK(slip_times_s(turned, data)[0] == doctest::Approx(slip_times_s(fitted.rig, data)[0]));
    const auto mean_ms = [&](const rig &rig) {
        return rig.robot.dead_time_ms + rig.robot.clock_phase_ms + 1e-3 * rig.robot.clock_drift_ppm * 7.5;
    };
    CHECK(mean_ms(turned) == doctest::Approx(mean_ms(fitted.rig)));
}

TEST_CASE("clock: slips that are off by dozens of ticks are found where the reports show them")
{
    /* Written out without the replay: at each of its own instants the robot takes the newest setpoint that has come,
     * and is there when the dead time has passed; on a line from one to the next. */
    const double drift_ppm = 190.0;
    const double phase_ms = 1.1;
    const rig true_rig = with_clock(drift_ppm, phase_ms);
    record data = record_of(30.0);
    const double arrival_s = setpoint_arrival_s(true_rig);
    REQUIRE(arrival_s > 0.05 * period_s); /* feedback goes first */
    const double own_period_s = period_s * (1.0 + 1e-6 * drift_ppm);
    const auto command_m = [](double t_s) { return t_s < 0.0 ? 0.0 : 0.02 * std::sin(5.0 * t_s); };
    const auto taken_m = [&](double at_s) {
        return command_m(period_s * std::floor((at_s - arrival_s) / period_s));
    };
    for (const double t_s : data.time_s) {
        data.command_position_m.push_back(command_m(t_s));
        const double own = (t_s - dead_time_s - 1e-3 * phase_ms) / own_period_s;
        const double instant_s = 1e-3 * phase_ms + std::floor(own) * own_period_s;
        const double share = own - std::floor(own);
        data.robot_position_m.push_back((1.0 - share) * taken_m(instant_s) +
                                        share * taken_m(instant_s + own_period_s));
    }
    const sample_events none;
    for (const double off_ms : {0.02, -0.03}) {
        CAPTURE(off_ms);
        fit_result fitted;
        fitted.rig = with_clock(drift_ppm + 1.5, phase_ms + off_ms); /* up to a hundred ticks off */
        fitted.parameters = {{find_key("robot.dead_time_ms"), 15.0, 20.0}};
        fitted.rows = data.size();
        block_model model(block::robot, data, fitted.rig, none, held_out_parts::none);
        noise_model noise;
        noise.sigma = noise.rms = 2e-6;
        noise.rows_per_fact = 1.0;
        CHECK(cost_of(model, noise, true_rig) < 1.0);
        const double before = cost_of(model, noise, fitted.rig);
        polish_clock(model, noise, fitted);
        CHECK(cost_of(model, noise, fitted.rig) < 0.05 * before);
        const std::vector<double> told_s = slip_times_s(fitted.rig, data);
        const std::vector<double> true_s = slip_times_s(true_rig, data);
        REQUIRE(told_s.size() == true_s.size());
        for (std::size_t i = 0; i < told_s.size(); i++) {
            CHECK(std::abs(told_s[i] - true_s[i]) < 3.0 * period_s);
        }
        CHECK(std::abs(fitted.rig.robot.clock_drift_ppm - drift_ppm) < 0.5);
    }
}

TEST_CASE("clock: a phase of a period more is the same clock")
{
    for (const double phase_ms : {0.4, 2.9, 5.4, -2.1}) {
        rig rig = with_clock(100.0, phase_ms);
        wrap_clock_phase(rig, period_s);
        CHECK(rig.robot.clock_phase_ms == doctest::Approx(0.4));
    }
}
