#include "effects.h"

namespace berth
{

effect object_parameters()
{
    effect made;
    made.name = "object.parameters";
    made.physics = "m, d and k lie beyond the tolerances that the rig file gives.";
    made.source = "the rig file";
    made.calibration = {13, "weigh the object, and measure its spring by itself"};
    made.parameters = {{"object.mass_kg", 1e-6, 1e9, {}},
                       {"object.damping_N_s_per_m", 0.0, 1e9, {}},
                       {"object.stiffness_N_per_m", 0.0, 1e12, {}}};
    made.starts = [](const rig &base, const record_scales &) {
        const double mass_kg = value_of(base, "object.mass_kg");
        const double damping_N_s_per_m = value_of(base, "object.damping_N_s_per_m");
        const double stiffness_N_per_m = value_of(base, "object.stiffness_N_per_m");
        std::vector<effect_values> all;
        for (const double share : {0.5, 0.8, 1.25, 2.0}) {
            all.push_back({share * mass_kg, damping_N_s_per_m, stiffness_N_per_m});
            all.push_back({mass_kg, share * share * damping_N_s_per_m, stiffness_N_per_m});
            all.push_back({mass_kg, damping_N_s_per_m, share * stiffness_N_per_m});
            all.push_back({share * mass_kg, share * damping_N_s_per_m, share * stiffness_N_per_m});
        }
        return all;
    };
    made.look_alike = "sensor.gain";
    return made;
}

} // namespace berth
