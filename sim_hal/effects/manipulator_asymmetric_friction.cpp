#include <algorithm>
#include <cmath>

#include "effects.h"
#include "force_laws.h"
#include "starts.h"

namespace berth
{

namespace
{

/* With presliding the dry friction z(x) Fc is bent over, as it turns round, from one direction's level to the
 * other's: by how much the levels differ builds up as |z|, and the constant force that stands for it lacks |z| - 1.
 */
class one_sided_friction final : public force_stage
{
  public:
    one_sided_friction(double asymmetry_N_s_per_m, double offset_N, double presliding_m)
        : asymmetry_(asymmetry_N_s_per_m), offset_N_(offset_N), bent_(1.0, presliding_m)
    {
    }
    void start(const body_motion &motion) override { bent_.start(motion); }
    double force_N(const body_motion &motion, double step_s) override
    {
        const double missing = bent_.builds_up() ? std::abs(bent_.force_N(motion, step_s)) - 1.0 : 0.0;
        return asymmetric_N(motion) + offset_N_ * missing;
    }

  private:
    /* Of the mean speed over the sub-step, which it lowers itself. */
    double asymmetric_N(const body_motion &motion) const
    {
        const double before = motion.velocity_before_m_per_s;
        const double after = motion.velocity_m_per_s;
        const double speeds = std::abs(before) + std::abs(after);
        const bool turns = before * after < 0.0;
        const double mean = turns ? (before * before + after * after) / (2.0 * speeds) : 0.5 * speeds;
        const double lowers = 0.5 * std::copysign(motion.velocity_per_force, after);
        return asymmetry_ * mean / (1.0 + asymmetry_ * lowers);
    }

    double asymmetry_;
    double offset_N_;
    dry_friction bent_;
};

} // namespace

effect manipulator_asymmetric_friction()
{
    effect made;
    made.name = "manipulator.asymmetric_friction";
    made.physics = "Friction differs between the directions: damping D + b where x' > 0, D - b where x' < 0. Dry "
                   "friction that differs as well is, while it moves, a constant force: manipulator.gravity_offset, "
                   "which builds up with the presliding then.";
    made.source = "Janot, Gautier & Brunot 2019 (EMPS benchmark)";
    made.calibration = {35, "pull the manipulator slowly forwards and backwards, and compare the forces"};
    made.parameters = {
        {"manipulator.damping_asymmetry_N_s_per_m", -1e7, 1e7, "b: damping is larger by it forwards"}};
    made.starts = [](const rig &, const record_scales &scales) {
        return both_signs({0.05 * scales.force_N / std::max(1e-12, scales.velocity_m_per_s)});
    };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        return std::make_unique<one_sided_friction>(value_of(rig, "manipulator.damping_asymmetry_N_s_per_m"),
                                                    value_of(rig, "manipulator.gravity_offset_N"),
                                                    value_of(rig, "manipulator.coulomb_presliding_m"));
    };
    made.refines = "manipulator.coulomb_friction";
    made.is_proportional = true;
    return made;
}

} // namespace berth
