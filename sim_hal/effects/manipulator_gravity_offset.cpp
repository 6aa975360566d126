#include "effects.h"
#include "force_laws.h"
#include "starts.h"

namespace berth
{

effect manipulator_gravity_offset()
{
    effect made;
    made.name = "manipulator.gravity_offset";
    made.physics = "A constant force G pulls the manipulator back: gravity, a cable, an amplifier's offset.";
    made.source = "Janot, Gautier & Brunot 2019 (EMPS benchmark)";
    made.calibration = {9, "hold the manipulator at rest, and read the force that it takes"};
    made.parameters = {{"manipulator.gravity_offset_N", -1e7, 1e7, "G: a constant force against the motion"}};
    made.starts = [](const rig &, const record_scales &scales) { return both_signs({0.03 * scales.force_N}); };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        return std::make_unique<constant_force>(value_of(rig, "manipulator.gravity_offset_N"));
    };
    made.is_proportional = true;
    made.when_small = small_motion::no_influence;
    return made;
}

} // namespace berth
