#include "effects.h"
#include "force_laws.h"
#include "starts.h"

namespace berth
{

effect robot_lag()
{
    effect made;
    made.name = "robot.lag";
    made.physics = "The robot follows like a first-order low-pass: tau r' = u - r.";
    made.source = "position controllers without feed-forward";
    made.calibration = {6, "time the robot's answer to a step with a recorder much faster than the loop"};
    made.parameters = {{"robot.lag_ms", 0.0, 2000.0, "tau of a first-order lag"}};
    made.look_alike = "robot.dead_time";
    made.starts = [](const rig &, const record_scales &scales) {
        return sizes({1e3 * scales.period_s, 8e3 * scales.period_s, 40.0});
    };
    made.on_motion = [](const rig &rig) -> std::unique_ptr<motion_stage> {
        return std::make_unique<first_order_lag>(1e-3 * value_of(rig, "robot.lag_ms"));
    };
    made.when_small = small_motion::in_the_equations;
    return made;
}

} // namespace berth
