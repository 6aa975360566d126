#include "effects.h"
#include "starts.h"

namespace berth
{

effect sensor_saturation()
{
    effect made;
    made.name = "sensor.saturation";
    made.physics = "The sensor shows no more than S: |y| <= S.";
    made.source = "data sheets of force sensors";
    made.calibration = {24, "load the sensor step by step up to the end of its range"};
    made.parameters = {{"sensor.saturation_N", 0.0, 1e7, {}}};
    made.starts = [](const rig &, const record_scales &scales) { return limits_below(scales.force_N); };
    return made;
}

} // namespace berth
