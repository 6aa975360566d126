#include <algorithm>

#include "effects.h"
#include "force_laws.h"

namespace berth
{

effect manipulator_asymmetric_friction()
{
    effect made;
    made.name = "manipulator.asymmetric_friction";
    made.physics =
        "Friction differs between the directions: Fc + a and D + b where x' > 0, Fc - a and D - b where x' < 0.";
    made.source = "Janot, Gautier & Brunot 2019 (EMPS benchmark)";
    made.parameters = {
        {"manipulator.friction_asymmetry_N", -1e7, 1e7, "a: dry friction is larger by it forwards"},
        {"manipulator.damping_asymmetry_N_s_per_m", -1e7, 1e7, "b: damping is larger by it forwards"}};
    made.starts = [](const rig &base, const record_scales &scales) {
        std::vector<effect_values> all;
        const double friction_N = value_of(base, "manipulator.coulomb_friction_N");
        const double damping_N_s_per_m = friction_N / std::max(1e-12, scales.velocity_m_per_s);
        for (const double share : {-0.1, 0.1}) {
            all.push_back({share * friction_N, 0.01 * share * damping_N_s_per_m});
            all.push_back({share * friction_N, share * damping_N_s_per_m});
            all.push_back({0.01 * share * friction_N, share * damping_N_s_per_m});
        }
        return all;
    };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        if (!has_asymmetry(rig)) {
            return nullptr;
        }
        const double friction_N = value_of(rig, "manipulator.coulomb_friction_N");
        const double asymmetry_N = value_of(rig, "manipulator.friction_asymmetry_N");
        const double damping = value_of(rig, "manipulator.damping_asymmetry_N_s_per_m");
        return std::make_unique<dry_friction>(dry_friction::side{std::max(0.0, friction_N + asymmetry_N), damping},
                                              dry_friction::side{std::max(0.0, friction_N - asymmetry_N), -damping},
                                              value_of(rig, "manipulator.coulomb_presliding_m"));
    };
    made.refines = "manipulator.coulomb_friction";
    made.reach = 100.0;
    return made;
}

} // namespace berth
