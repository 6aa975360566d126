#include "effects.h"
#include "starts.h"

namespace berth
{

effect sensor_bias()
{
    effect made;
    made.name = "sensor.bias";
    made.physics = "Every sample has the error b.";
    made.source = "data sheets of force sensors";
    made.calibration = {2, "read the sensor with nothing attached to it"};
    made.parameters = {{"sensor.bias_N", -1e7, 1e7, {}}};
    made.starts = [](const rig &, const record_scales &scales) { return both_signs({0.02 * scales.force_N}); };
    made.is_proportional = true;
    return made;
}

} // namespace berth
