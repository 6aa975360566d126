/* The interval of a threshold that no row of the record lies near: the error is flat about it. */
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/diagnosis/fit/fit.h"

using namespace berth;

TEST_CASE("fit: a threshold that the error is flat about is known from the last setpoint that was ignored to the "
          "first that was not")
{
    const rig given = load_rig("ess", {"robot.deadband_m=2.5e-4"});
    record data;
    data.period_s = config_period_s(&given.firmware);
    constexpr std::size_t rows = 4000;
    data.segments = {{0, rows}};
    for (std::size_t n = 0; n < rows; n++) { /* steps of 0.2 mm, which are ignored, and of 0.4 mm, which are not */
        data.time_s.push_back(data.period_s * static_cast<double>(n));
        data.command_position_m.push_back(n % 800 < 200 ? 0.0 : n % 800 < 400 ? 2e-4 : n % 800 < 600 ? 0.0 : 4e-4);
    }
    robot_motion motion;
    replay_robot(given, data, {}, motion_detail::way, 1, motion);
    data.robot_position_m = motion.at_tick_m;
    for (std::size_t n = 0; n < rows; n++) {
        data.robot_position_m[n] += n % 2 == 0 ? 5e-6 : -5e-6;
    }
    const sample_events events;
    block_model model(block::robot, data, given, events, held_out_parts::none);
    noise_model noise;
    noise.sigma = noise.rms = 5e-6;
    const fit_result found = fit(model, noise, given, {{find_key("robot.deadband_m"), 0.0, 1e-3}}, 60);
    REQUIRE(found.ci95.size() == 1);
    const double value = value_of(found.rig, "robot.deadband_m");
    CHECK(found.ci95[0] >= std::max(value - 2e-4, 4e-4 - value));
    CHECK(found.ci95[0] <= 2.0 * std::max(value - 2e-4, 4e-4 - value));
}
