#include "effects.h"

namespace berth
{

effect sensor_dropouts()
{
    effect made;
    made.name = "sensor.dropouts";
    made.physics = "A sample does not come with probability p; the last one stands.";
    made.source = "bus load, radio links";
    made.parameters = {{"sensor.loss_probability", 0.0, 1.0, {}}};
    made.is_of_single_samples = true;
    return made;
}

} // namespace berth
