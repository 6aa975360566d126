#include "effects.h"
#include "starts.h"

namespace berth
{

effect robot_dead_time()
{
    effect made;
    made.name = "robot.dead_time";
    made.physics = "The robot moves later or earlier than told: r(t) = x(t - T_R) with another T_R.";
    made.source = "Krenn & Schaefer, Fig. 6";
    made.calibration = {5, "time the robot's answer to a step with a recorder much faster than the loop"};
    made.parameters = {{"robot.dead_time_ms", 0.0, 1000.0, {}}};
    made.starts = [](const rig &base, const record_scales &scales) {
        return shifted(base.robot.dead_time_ms, 1e3 * scales.period_s);
    };
    return made;
}

} // namespace berth
