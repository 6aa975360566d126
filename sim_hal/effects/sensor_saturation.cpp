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
    made.parameters = {{"sensor.saturation_N", 0.0, 1e7, {}}};
    made.starts = [](const rig &, const record_scales &scales) {
        return sizes_of(scales.force_N, {0.3, 0.6, 0.8, 0.9, 0.97});
    };
    return made;
}

} // namespace berth
