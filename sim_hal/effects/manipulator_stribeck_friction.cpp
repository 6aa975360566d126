#include <algorithm>
#include <cmath>

#include "effects.h"
#include "force_laws.h"

namespace berth
{

namespace
{

/* On top of the dry friction, which acts before it in a sub-step: whatever still moves the body then, it stops, but
 * with no more than its own level. */
class stribeck_friction final : public force_stage
{
  public:
    stribeck_friction(double excess_N, double velocity_m_per_s, double presliding_m)
        : excess_N_(excess_N), velocity_m_per_s_(velocity_m_per_s), bent_(1.0, presliding_m)
    {
    }
    void start(const body_motion &motion) override { bent_.start(motion); }
    double force_N(const body_motion &motion, double step_s) override
    {
        /* Of the mean velocity over the sub-step, which it lowers itself. */
        const double alone_m_per_s = 0.5 * (motion.velocity_before_m_per_s + motion.velocity_m_per_s);
        const double lowers_m_per_s = 0.5 * motion.velocity_per_force * level_N_at(alone_m_per_s);
        const double level_N = level_N_at(std::max(0.0, std::abs(alone_m_per_s) - lowers_m_per_s));
        if (bent_.builds_up()) {
            return level_N * bent_.force_N(motion, step_s);
        }
        const double stops_N = motion.velocity_m_per_s / motion.velocity_per_force;
        return std::min(std::max(stops_N, -level_N), level_N);
    }

  private:
    double level_N_at(double speed_m_per_s) const
    {
        const double ratio = speed_m_per_s / velocity_m_per_s_;
        return excess_N_ * std::exp(-ratio * ratio);
    }

    double excess_N_;
    double velocity_m_per_s_;
    dry_friction bent_;
};

} // namespace

effect manipulator_stribeck_friction()
{
    effect made;
    made.name = "manipulator.stribeck_friction";
    made.physics = "Dry friction is larger in slow motion: Fc + Fs exp(-(x'/vs)^2), against the motion.";
    made.source = "Stribeck 1902; Bo & Pavelescu 1982";
    made.calibration = {20, "pull the manipulator at several slow speeds, and record the force over the speed"};
    made.parameters = {{"manipulator.stribeck_friction_N", 0.0, 1e7, "Fs: dry friction at rest is larger by it"},
                       {"manipulator.stribeck_velocity_m_per_s", 1e-9, 1e3, "vs, the speed over which that is lost"},
                       {"manipulator.coulomb_friction_N", 0.0, 1e7, {}}};
    made.starts = [](const rig &base, const record_scales &scales) {
        const double known_N = value_of(base, "manipulator.coulomb_friction_N");
        const double dry_N = known_N > 0.0 ? known_N : 0.02 * scales.force_N;
        std::vector<effect_values> all;
        for (const double share : {0.02, 0.06, 0.2}) {
            all.push_back({0.5 * dry_N, share * scales.velocity_m_per_s, dry_N});
        }
        return all;
    };
    made.on_body = [](const rig &rig) -> std::unique_ptr<force_stage> {
        return std::make_unique<stribeck_friction>(value_of(rig, "manipulator.stribeck_friction_N"),
                                                   value_of(rig, "manipulator.stribeck_velocity_m_per_s"),
                                                   value_of(rig, "manipulator.coulomb_presliding_m"));
    };
    made.generalises = "manipulator.coulomb_friction";
    made.sizes = 1;
    made.is_proportional = true;
    made.precision = 3e-4; /* as manipulator.coulomb_friction */
    return made;
}

} // namespace berth
