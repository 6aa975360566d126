#include "effects.h"
#include "starts.h"

namespace berth
{

/* The plant's equations have it: its force goes through the sensor's low-pass like any other. */
effect sensor_tool_inertia()
{
    effect made;
    made.name = "sensor.tool_inertia";
    made.physics =
        "A tool of mass mT between the sensor and what it touches: the sensor also reads what moves the tool, "
        "F + mT r'', r the robot's position.";
    made.source = "force sensors between flange and tool";
    made.calibration = {19,
                        "move the tool with nothing attached to it, and compare the force with the acceleration"};
    made.parameters = {{"sensor.tool_mass_kg", 0.0, 1e6, "mT, mass of the tool between sensor and object; 0: none"}};
    made.generalises = "object.parameters"; /* on a stiff sensor the object moves as the tool does */
    made.is_seen = [](const rig &fitted, const record_scales &) {
        /* Corners of the robot's way are replayed to a part of a tick: behind play of 0.1 mm, what that leaves of
         * the force looked like a tool of 0.2 % of the object's mass. */
        constexpr double least_share = 0.005;
        return value_of(fitted, "sensor.tool_mass_kg") > least_share * fitted.object.mass_kg;
    };
    made.starts = [](const rig &base, const record_scales &scales) {
        return base.sensor.low_pass_order < 2
                   ? std::vector<effect_values>{}
                   : sizes_of(scales.force_N / std::max(1e-12, scales.acceleration_m_per_s2), {0.02, 0.2});
    };
    made.is_proportional = true;
    made.when_small = small_motion::in_the_equations;
    return made;
}

} // namespace berth
