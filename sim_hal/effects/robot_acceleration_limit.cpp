#include "effects.h"
#include "starts.h"

namespace berth
{

effect robot_acceleration_limit()
{
    effect made;
    made.name = "robot.acceleration_limit";
    made.physics = "The robot follows as fast as |r''| <= A permits.";
    made.source = "drive limits";
    made.calibration = {16,
                        "command a step, and record the robot's way with an instrument much faster than the loop"};
    made.parameters = {{"robot.acceleration_limit_m_per_s2", 1e-9, 1e9, {}}};
    made.starts = [](const rig &, const record_scales &scales) {
        return limits_below(scales.acceleration_m_per_s2);
    };
    made.is_rough = true;
    made.switches = true;
    made.hides_in_reports = true;
    return made;
}

} // namespace berth
