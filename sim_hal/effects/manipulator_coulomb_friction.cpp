#include "effects.h"
#include "force_laws.h"

namespace berth
{

effect manipulator_coulomb_friction()
{
    effect made;
    made.name = "manipulator.coulomb_friction";
    made.physics = "Dry friction: Fc sign(x') against the motion, and as much as is needed to stick.";
    made.source = "Coulomb; time stepping after Moreau";
    made.calibration = {12, "pull the manipulator slowly over short ways, and record the force over the way"};
    made.parameters = {{"manipulator.coulomb_friction_N", 0.0, 1e7, "dry friction"},
                       {"manipulator.coulomb_presliding_m", 0.0, 1.0, "way over which dry friction builds up"}};
    made.starts = [](const rig &, const record_scales &scales) { return friction_starts(scales); };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        return std::make_unique<dry_friction>(value_of(rig, "manipulator.coulomb_friction_N"),
                                              value_of(rig, "manipulator.coulomb_presliding_m"));
    };
    made.is_proportional = true;
    made.precision = 3e-4; /* of an event-accurate simulation's it is 0.3e-4 to 2.3e-4 off, at any noise */
    made.has_minima_by_scale = true;
    return made;
}

} // namespace berth
