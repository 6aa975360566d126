#include "effects.h"
#include "starts.h"

namespace berth
{

effect object_loss_of_contact()
{
    effect made;
    made.name = "object.loss_of_contact";
    made.physics =
        "The grip pulls no more than F_hold: beyond it the object is loose, F = 0, until it is touched again "
        "without such a pull.";
    made.source = "grippers, magnets, one-sided contact";
    made.calibration = {31, "pull the grip by hand until it gives way, and read the force"};
    made.parameters = {{"object.grip_force_N", 0.0, 1e7, "the grip lets go where it has to pull more; 0: never"}};
    made.starts = [](const rig &, const record_scales &scales) { return grid_of(scales.force_N, 0.02, 0.98, 48); };
    made.is_rough = true;
    made.switches = true;
    made.decides_what_follows = true;
    made.fits_max = 3;
    made.when_small = small_motion::higher_order;
    made.object = object_needed::no_contact;
    return made;
}

} // namespace berth
