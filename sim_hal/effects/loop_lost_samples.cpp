#include "effects.h"

namespace berth
{

effect loop_lost_samples()
{
    effect made;
    made.name = "loop.lost_samples";
    made.physics = "With probability p a tick's robot position and force both stay the previous ones.";
    made.source = "a loop that missed a tick";
    made.parameters = {
        {"loop.lost_sample_probability", 0.0, 1.0, "a tick's robot position and force stay the previous ones"}};
    made.is_of_single_samples = true;
    made.when_small = small_motion::in_the_equations;
    return made;
}

} // namespace berth
