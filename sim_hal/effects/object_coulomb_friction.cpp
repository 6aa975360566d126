#include "effects.h"
#include "force_laws.h"
#include "starts.h"

namespace berth
{

effect object_coulomb_friction()
{
    effect made;
    made.name = "object.coulomb_friction";
    made.physics = "Dry friction: Fc sign(x') against the motion, and as much as is needed to stick.";
    made.source = "Coulomb; time stepping after Moreau";
    made.parameters = {{"object.coulomb_friction_N", 0.0, 1e7, "dry friction"}};
    made.starts = [](const rig &, const record_scales &scales) {
        return sizes_of(scales.force_N, {0.01, 0.05, 0.2});
    };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        const double friction_N = value_of(rig, "object.coulomb_friction_N");
        return std::make_unique<dry_friction>(friction_N, friction_N, 0.0, 0.0);
    };
    return made;
}

} // namespace berth
