/* The robot replayed in one step a tick against many. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <vector>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/diagnosis/replay/driven_path.h"
#include "../../sim_hal/diagnosis/replay/replay.h"
#include "../../sim_hal/diagnosis/replay/robot_start.h"

using namespace berth;

namespace
{

record wandering_command(double period_s)
{
    record made;
    made.period_s = period_s;
    for (int n = 0; n < 2000; n++) {
        const double t_s = period_s * n;
        made.time_s.push_back(t_s);
        made.command_position_m.push_back(0.01 * std::sin(9.0 * t_s) + 0.004 * std::sin(31.0 * t_s + 1.0));
    }
    made.segments.push_back({0, made.time_s.size()});
    return made;
}

robot_motion replayed(const std::vector<std::string> &settings, motion_detail detail)
{
    const rig rig = load_rig("ess", settings);
    robot_motion motion;
    replay_robot(rig, wandering_command(config_period_s(&rig.firmware)), {}, detail, 1, motion);
    return motion;
}

double largest_difference_m(const std::vector<double> &a, const std::vector<double> &b)
{
    REQUIRE(a.size() == b.size());
    double largest = 0.0;
    for (std::size_t n = 0; n < a.size(); n++) {
        largest = std::max(largest, std::abs(a[n] - b[n]));
    }
    return largest;
}

} // namespace

TEST_CASE("robot: where it is at the ticks needs no steps between, if one thing with a memory alone bends its way")
{
    const std::vector<std::vector<std::string>> alone = {
        {"robot.backlash_m=1e-3"},
        {"robot.lag_ms=7"},
        {"robot.lag_ms=20", "robot.velocity_limit_m_per_s=0.05"},
        {"robot.periodic_error_m=1e-4", "robot.periodic_error_pitch_m=3e-3"},
        {"robot.transfer_frequency_Hz=12", "robot.transfer_damping_ratio=0.6"},
        {"robot.backlash_m=1e-3", "robot.periodic_error_m=1e-4", "robot.periodic_error_pitch_m=3e-3"},
    };
    for (const std::vector<std::string> &settings : alone) {
        CAPTURE(settings[0]);
        const robot_motion coarse = replayed(settings, motion_detail::at_ticks);
        const robot_motion fine = replayed(settings, motion_detail::way);
        CHECK(coarse.tick.count() <= 2);
        CHECK(fine.tick.count() >= 4);
        CHECK(largest_difference_m(coarse.at_tick_m, fine.at_tick_m) < 1e-12);
    }
}

TEST_CASE("robot: two things that bend its way one after the other keep their steps")
{
    const std::vector<std::string> settings = {"robot.backlash_m=1e-3", "robot.transfer_frequency_Hz=12",
                                               "robot.transfer_damping_ratio=0.6"};
    CHECK(replayed(settings, motion_detail::at_ticks).tick.count() >= 8);
}

TEST_CASE("robot: what a decoder of lost setpoints takes for its way is the way that is replayed")
{
    constexpr std::size_t late = 4; /* ticks */
    for (const char *const acts :
         {"robot.gain_error=0.1", "robot.deadband_m=2e-4", "robot.velocity_limit_m_per_s=0.05",
          "robot.acceleration_limit_m_per_s2=2", "robot.backlash_m=1e-3"}) {
        CAPTURE(std::string(acts));
        const rig rig = load_rig("ess", {acts, "robot.dead_time_ms=10"});
        const record record = wandering_command(config_period_s(&rig.firmware));
        REQUIRE(record.period_s == doctest::Approx(0.0025));
        sample_events events;
        for (std::size_t n = 0; n < record.size(); n++) {
            events.lost_command.push_back(n > 0 && (n % 7 == 3 || n % 31 < 3)); /* up to three in a row */
        }
        robot_motion motion;
        replay_robot(rig, record, events, motion_detail::at_ticks, 1, motion);
        driven_path path(rig, record);
        double largest_m = 0.0;
        for (std::size_t n = 1; n + late < record.size(); n++) {
            const double at_m = events.lost_command[n] != 0 ? path.go_on() : path.take(record.command_position_m[n]);
            largest_m = std::max(largest_m, std::abs(at_m - motion.at_tick_m[n + late]));
        }
        CHECK(largest_m < 1e-12);
    }
}

/* tau r' = u - r within |r'| <= V, by Euler's rule in steps of a thousandth of a tick. */
TEST_CASE("robot: a velocity limit is within the lag")
{
    constexpr double lag_s = 0.02;
    for (const double limit_m_per_s : {0.03, 0.08, 0.15}) {
        CAPTURE(limit_m_per_s);
        const robot_motion found = replayed({"robot.dead_time_ms=2.5", "robot.lag_ms=20",
                                             "robot.velocity_limit_m_per_s=" + std::to_string(limit_m_per_s)},
                                            motion_detail::at_ticks);
        const record told = wandering_command(0.0025);
        const std::vector<double> &u_m = told.command_position_m;
        constexpr int steps = 1000;
        double r_m = u_m[0];
        double before_m = r_m;
        double worst_m = 0.0;
        std::size_t at_limit = 0;
        /* With a dead time of one period the line to a setpoint begins where that is sent. */
        for (std::size_t n = 1; n + 1 < u_m.size(); n++) {
            for (int i = 0; i < steps; i++) {
                const double goal_m = u_m[n - 1] + (u_m[n] - u_m[n - 1]) * (i + 0.5) / steps;
                const double wish = (goal_m - r_m) / lag_s;
                r_m += told.period_s / steps * std::clamp(wish, -limit_m_per_s, limit_m_per_s);
            }
            worst_m = std::max(worst_m, std::abs(r_m - found.at_tick_m[n + 1]));
            const double moved_m = std::abs(found.at_tick_m[n + 1] - before_m);
            before_m = found.at_tick_m[n + 1];
            CHECK(moved_m <= limit_m_per_s * told.period_s * (1.0 + 1e-9));
            at_limit += moved_m > 0.999 * limit_m_per_s * told.period_s ? 1 : 0;
        }
        CHECK(worst_m < 2e-6);
        CHECK(at_limit > 100);
    }
    const auto slow = replayed({"robot.lag_ms=20"}, motion_detail::at_ticks);
    const auto never_limited =
        replayed({"robot.lag_ms=20", "robot.velocity_limit_m_per_s=5"}, motion_detail::at_ticks);
    CHECK(largest_difference_m(slow.at_tick_m, never_limited.at_tick_m) < 1e-12);
}

/* r' = V towards u until there, then u': by steps of a thousandth of a tick. */
TEST_CASE("robot: a velocity limit without a lag is on the reference between the ticks")
{
    for (const bool holds : {false, true}) {
        for (const double limit_m_per_s : {0.03, 0.08, 0.15}) {
            CAPTURE(holds);
            CAPTURE(limit_m_per_s);
            const robot_motion found = replayed({"robot.dead_time_ms=2.5",
                                                 holds ? "robot.interpolation=hold" : "robot.interpolation=linear",
                                                 "robot.velocity_limit_m_per_s=" + std::to_string(limit_m_per_s)},
                                                motion_detail::at_ticks);
            const record told = wandering_command(0.0025);
            const std::vector<double> &u_m = told.command_position_m;
            constexpr int steps = 1000;
            const double reach_m = limit_m_per_s * told.period_s / steps;
            double r_m = u_m[0];
            double worst_m = 0.0;
            /* With a dead time of one period the line to a setpoint begins where that is sent; the jump ends it. */
            for (std::size_t n = 1; n + 1 < u_m.size(); n++) {
                for (int i = 1; i <= steps; i++) {
                    const double goal_m = holds ? u_m[n - 1] : u_m[n - 1] + (u_m[n] - u_m[n - 1]) * i / steps;
                    r_m += std::clamp(goal_m - r_m, -reach_m, reach_m);
                }
                worst_m = std::max(worst_m, std::abs(r_m - found.at_tick_m[n + 1]));
            }
            CHECK(worst_m < 1e-6);
        }
    }
    const auto free = replayed({}, motion_detail::at_ticks);
    const auto never_limited = replayed({"robot.velocity_limit_m_per_s=5"}, motion_detail::at_ticks);
    CHECK(largest_difference_m(free.at_tick_m, never_limited.at_tick_m) < 1e-12);
}

/* A step from where the robot stands, though the record begins with the setpoint already there. */
TEST_CASE("robot: a part that begins where the robot stands elsewhere is replayed from there")
{
    const rig rig = load_rig("ess", {"robot.dead_time_ms=20", "robot.lag_ms=50", "robot.interpolation=hold"});
    const double dead_time_s = 0.02 + 1e-9 * static_cast<double>(sync_wait_ns(rig));
    record made;
    made.period_s = 0.0025;
    for (int n = 0; n < 400; n++) {
        made.time_s.push_back(made.period_s * n);
        made.command_position_m.push_back(0.1);
        const double since_s = std::max(0.0, made.period_s * n - dead_time_s);
        made.robot_position_m.push_back(0.1 * (1.0 - std::exp(-since_s / 0.05)));
    }
    made.command_position_m.back() = -0.1; /* the range of the record */
    made.segments.push_back({0, made.time_s.size()});
    find_starts_elsewhere(made);
    REQUIRE(made.segments[0].stands_m.has_value());
    CHECK(*made.segments[0].stands_m == 0.0);
    robot_motion motion;
    replay_robot(rig, made, {}, motion_detail::at_ticks, 1, motion);
    CHECK(largest_difference_m(motion.at_tick_m, made.robot_position_m) < 1e-12);

    /* A robot with a wrong gain stands beside its setpoint, and stays there. */
    for (double &position_m : made.robot_position_m) {
        position_m = 0.08;
    }
    made.segments[0].stands_m.reset();
    find_starts_elsewhere(made);
    CHECK_FALSE(made.segments[0].stands_m.has_value());
}

/* A robot that came from elsewhere stands anywhere in its gap, seen with noise: against the play operator, and
 * against the last setpoint that was taken. */
TEST_CASE("robot: what moves only beyond a gap is replayed from where it was seen in it")
{
    constexpr int late_ticks = 7; /* the rig's dead time of 17.5 ms */
    constexpr double gap_m = 5e-4;
    for (const bool has_play : {true, false}) {
        const rig rig = load_rig("ess", {has_play ? "robot.backlash_m=1e-3" : "robot.deadband_m=5e-4"});
        for (const double start_m : {-4e-4, 1e-4, 3e-4}) {
            CAPTURE(has_play);
            CAPTURE(start_m);
            record made = wandering_command(config_period_s(&rig.firmware));
            std::vector<double> true_m;
            double robot_m = start_m;
            for (std::size_t n = 0; n < made.size(); n++) {
                const double at_rest =
                    n < 30 ? 0.0 : 1.0 - std::exp(-1e-4 * std::pow(static_cast<double>(n) - 30.0, 2));
                made.command_position_m[n] *= at_rest;
                const double goal_m = n < late_ticks ? 0.0 : made.command_position_m[n - late_ticks];
                if (has_play) {
                    robot_m = std::min(std::max(robot_m, goal_m - gap_m), goal_m + gap_m);
                } else if (std::abs(goal_m - robot_m) > gap_m) {
                    robot_m = goal_m;
                }
                true_m.push_back(robot_m);
                made.robot_position_m.push_back(robot_m + (n % 2 == 0 ? 2e-6 : -2e-6));
            }
            robot_motion motion;
            replay_robot(rig, made, {}, motion_detail::at_ticks, 1, motion);
            CHECK(largest_difference_m(motion.at_tick_m, true_m) < 1e-6);
        }
    }
}
