#include "effects.h"

namespace berth
{

effect manipulator_parameters()
{
    effect made;
    made.name = "manipulator.parameters";
    made.physics = "M, D and K lie beyond the tolerances that the rig file gives.";
    made.source = "the rig file";
    made.calibration = {14, "weigh what the manipulator moves, and measure its spring by itself"};
    made.parameters = {{"manipulator.mass_kg", 1e-6, 1e9, {}},
                       {"manipulator.damping_N_s_per_m", 0.0, 1e9, {}},
                       {"manipulator.stiffness_N_per_m", 0.0, 1e12, {}}};
    made.starts = [](const rig &base, const record_scales &) {
        const double mass_kg = value_of(base, "manipulator.mass_kg");
        const double damping_N_s_per_m = value_of(base, "manipulator.damping_N_s_per_m");
        const double stiffness_N_per_m = value_of(base, "manipulator.stiffness_N_per_m");
        std::vector<effect_values> all;
        for (const double share : {0.5, 0.8, 1.25, 2.0}) {
            all.push_back({share * mass_kg, damping_N_s_per_m, stiffness_N_per_m});
            all.push_back({mass_kg, share * share * damping_N_s_per_m, stiffness_N_per_m});
            all.push_back({mass_kg, damping_N_s_per_m, share * stiffness_N_per_m});
            all.push_back({share * mass_kg, share * damping_N_s_per_m, share * stiffness_N_per_m});
        }
        return all;
    };
    return made;
}

} // namespace berth
