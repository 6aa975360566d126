#include "effects.h"
#include "force_laws.h"
#include "starts.h"

namespace berth
{

effect object_backlash()
{
    effect made;
    made.name = "object.backlash";
    made.physics = "The spring has a gap of width b in its middle, in which it gives no force.";
    made.source = "joints with play";
    made.calibration = {
        27, "push and pull the object by hand, and read on a dial gauge how far it moves while no force acts"};
    made.parameters = {{"object.backlash_m", 0.0, 10.0, "full width of the gap in the spring"}};
    made.starts = [](const rig &, const record_scales &scales) {
        return sizes_of(scales.position_m, {3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 0.8});
    };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        return std::make_unique<spring_gap>(value_of(rig, "object.stiffness_N_per_m"),
                                            0.5 * value_of(rig, "object.backlash_m"));
    };
    made.object = object_needed::no_contact;
    return made;
}

} // namespace berth
