#include "effects.h"
#include "starts.h"

namespace berth
{

effect robot_dead_time_drift()
{
    effect made;
    made.name = "robot.dead_time_drift";
    made.physics = "The dead time grows or shrinks while the loop runs: T_R(t) = T_R + r t.";
    made.source = "a queue that fills where two clocks differ";
    made.calibration = {21, "time the robot's answer to a step at the start of a long run and at its end"};
    made.parameters = {{"robot.dead_time_drift_ms_per_s", -20.0, 20.0, "change of the dead time"}};
    made.starts = [](const rig &, const record_scales &scales) {
        return both_signs({1e3 * scales.period_s / scales.duration_s, 8e3 * scales.period_s / scales.duration_s});
    };
    made.is_proportional = true;
    made.when_small = small_motion::drifts;
    return made;
}

} // namespace berth
