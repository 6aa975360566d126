#include "effects.h"

namespace berth
{

effect manipulator_parameters()
{
    effect made;
    made.name = "manipulator.parameters";
    made.physics = "M, D and K lie beyond the tolerances that the rig file gives.";
    made.source = "the rig file";
    made.parameters = {{"manipulator.mass_kg", 1e-6, 1e9, {}},
                       {"manipulator.damping_N_s_per_m", 0.0, 1e9, {}},
                       {"manipulator.stiffness_N_per_m", 0.0, 1e12, {}}};
    made.starts = [](const rig &base, const record_scales &) {
        const double mass_kg = value_of(base, "manipulator.mass_kg");
        const double damping_N_s_per_m = value_of(base, "manipulator.damping_N_s_per_m");
        const double stiffness_N_per_m = value_of(base, "manipulator.stiffness_N_per_m");
        return std::vector<effect_values>{{1.1 * mass_kg, 1.1 * damping_N_s_per_m, 1.1 * stiffness_N_per_m},
                                          {0.9 * mass_kg, 0.9 * damping_N_s_per_m, 1.1 * stiffness_N_per_m}};
    };
    return made;
}

} // namespace berth
