#include "effects.h"

namespace berth
{

effect sensor_quantisation()
{
    effect made;
    made.name = "sensor.quantisation";
    made.physics = "The sensor shows steps of q.";
    made.source = "analogue-digital converters";
    made.parameters = {{"sensor.resolution_N", 0.0, 1e6, {}}};
    made.is_of_single_samples = true;
    return made;
}

} // namespace berth
