#include <cmath>

#include "effects.h"

namespace berth
{

effect object_parameters()
{
    effect made;
    made.name = "object.parameters";
    made.physics =
        "m, d and k lie beyond the tolerances that the rig file gives, and with m the damping ratio of the "
        "sensor's spring, c = 2 zeta sqrt(m ks).";
    made.source = "the rig file";
    made.calibration = {13, "weigh the object, and measure its spring by itself"};
    made.parameters = {{"object.mass_kg", 1e-6, 1e9, {}},
                       {"object.damping_N_s_per_m", 0.0, 1e9, {}},
                       {"object.stiffness_N_per_m", 0.0, 1e12, {}},
                       {"sensor.damping_ratio", 0.0, 1e4, {}}};
    made.starts = [](const rig &base, const record_scales &) {
        const double mass_kg = value_of(base, "object.mass_kg");
        const double damping_N_s_per_m = value_of(base, "object.damping_N_s_per_m");
        const double stiffness_N_per_m = value_of(base, "object.stiffness_N_per_m");
        const double damping_ratio = value_of(base, "sensor.damping_ratio");
        /* The sensor's spring damps as it did, whatever hangs on it: its ratio is one of another mass. */
        const auto as_heavy = [&](double share) { return damping_ratio / std::sqrt(share); };
        std::vector<effect_values> all;
        for (const double share : {0.5, 0.8, 1.25, 2.0}) {
            all.push_back({share * mass_kg, damping_N_s_per_m, stiffness_N_per_m, as_heavy(share)});
            all.push_back({mass_kg, share * share * damping_N_s_per_m, stiffness_N_per_m, damping_ratio});
            all.push_back({mass_kg, damping_N_s_per_m, share * stiffness_N_per_m, damping_ratio});
            all.push_back({share * mass_kg, share * damping_N_s_per_m, share * stiffness_N_per_m, as_heavy(share)});
        }
        return all;
    };
    made.look_alike = "sensor.gain";
    return made;
}

} // namespace berth
