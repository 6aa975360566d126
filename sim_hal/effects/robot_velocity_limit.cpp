#include "effects.h"
#include "starts.h"

namespace berth
{

effect robot_velocity_limit()
{
    effect made;
    made.name = "robot.velocity_limit";
    made.physics =
        "The robot follows its reference as fast as |r'| <= V permits, and catches up; with a lag, tau r' = u - r "
        "within it.";
    made.source = "drive limits; MuJoCo servo records show it as triangles instead of sines";
    made.calibration = {15, "command a move as long and as fast as may be, and time the robot between two marks"};
    made.parameters = {{"robot.velocity_limit_m_per_s", 1e-9, 1e9, {}}};
    made.starts = [](const rig &, const record_scales &scales) { return limits_below(scales.velocity_m_per_s); };
    made.switches = true;
    made.hides_in_reports = true;
    return made;
}

} // namespace berth
