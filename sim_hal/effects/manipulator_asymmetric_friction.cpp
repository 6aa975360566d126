#include <algorithm>
#include <cmath>

#include "effects.h"
#include "starts.h"

namespace berth
{

namespace
{

class one_sided_damping final : public force_stage
{
  public:
    explicit one_sided_damping(double asymmetry_N_s_per_m) : asymmetry_(asymmetry_N_s_per_m) {}
    double force_N(const body_motion &motion, double) override
    {
        return asymmetry_ * std::abs(motion.velocity_m_per_s);
    }

  private:
    double asymmetry_;
};

} // namespace

effect manipulator_asymmetric_friction()
{
    effect made;
    made.name = "manipulator.asymmetric_friction";
    made.physics = "Friction differs between the directions: damping D + b where x' > 0, D - b where x' < 0. Dry "
                   "friction that differs as well is, while it moves, a constant force: manipulator.gravity_offset.";
    made.source = "Janot, Gautier & Brunot 2019 (EMPS benchmark)";
    made.parameters = {
        {"manipulator.damping_asymmetry_N_s_per_m", -1e7, 1e7, "b: damping is larger by it forwards"}};
    made.starts = [](const rig &, const record_scales &scales) {
        return both_signs({0.05 * scales.force_N / std::max(1e-12, scales.velocity_m_per_s)});
    };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        return std::make_unique<one_sided_damping>(value_of(rig, "manipulator.damping_asymmetry_N_s_per_m"));
    };
    made.refines = "manipulator.coulomb_friction";
    made.is_proportional = true;
    return made;
}

} // namespace berth
