#include "effects.h"

namespace berth
{

effect sensor_spikes()
{
    effect made;
    made.name = "sensor.spikes";
    made.physics = "With probability p a single sample has an error of about +-A.";
    made.source = "electromagnetic disturbance";
    made.parameters = {{"sensor.spike_probability", 0.0, 1.0, "probability that a single sample is off"},
                       {"sensor.spike_N", 0.0, 1e7, "size of such a spike, either way"}};
    made.is_of_single_samples = true;
    made.when_small = small_motion::no_influence;
    return made;
}

} // namespace berth
