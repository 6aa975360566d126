#include "effects.h"
#include "force_laws.h"

namespace berth
{

effect object_coulomb_friction()
{
    effect made;
    made.name = "object.coulomb_friction";
    made.physics = "Dry friction: Fc sign(x') against the motion, and as much as is needed to stick.";
    made.source = "Coulomb; time stepping after Moreau";
    made.calibration = {11, "pull the object slowly over short ways, and record its force over the way"};
    made.parameters = {{"object.coulomb_friction_N", 0.0, 1e7, "dry friction"},
                       {"object.coulomb_presliding_m", 0.0, 1.0, "way over which dry friction builds up"}};
    made.starts = [](const rig &, const record_scales &scales) { return friction_starts(scales); };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        return std::make_unique<dry_friction>(value_of(rig, "object.coulomb_friction_N"),
                                              value_of(rig, "object.coulomb_presliding_m"));
    };
    made.is_seen = [](const rig &fitted, const record_scales &scales) {
        constexpr double longest = 0.02; /* of the way: what builds up over more is a hysteresis */
        return value_of(fitted, "object.coulomb_presliding_m") < longest * scales.position_m;
    };
    made.is_proportional = true;
    made.has_minima_by_scale = true;
    return made;
}

} // namespace berth
