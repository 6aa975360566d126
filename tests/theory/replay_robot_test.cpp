/* The robot replayed in one step a tick against many. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <vector>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/diagnosis/replay.h"

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

TEST_CASE("robot: where it is at the ticks needs no steps between, if one thing alone bends its way")
{
    const std::vector<std::vector<std::string>> alone = {
        {"robot.backlash_m=1e-3"},
        {"robot.lag_ms=7"},
        {"robot.periodic_error_m=1e-4", "robot.periodic_error_pitch_m=3e-3"},
        {"robot.transfer_frequency_Hz=12", "robot.transfer_damping_ratio=0.6"},
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
