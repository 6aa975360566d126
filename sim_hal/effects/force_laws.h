/* Laws that more than one block knows. */
#ifndef SIM_HAL_EFFECTS_FORCE_LAWS_H
#define SIM_HAL_EFFECTS_FORCE_LAWS_H

#include <algorithm>
#include <cmath>

#include "by_step.h"
#include "effect.h"

namespace berth
{

/* Of the presliding way: over it the force is straight to 1e-4 of itself. */
constexpr double coarse_way = 0.03;

/* Dry friction. Without presliding: whatever stops the body within the sub-step, but no more than the friction, so
 * that it sticks and slides without a limit velocity. With presliding the force builds up over a short way, as
 * asperities bend (Dahl 1968), exact over the way of a sub-step. */
class dry_friction final : public force_stage
{
  public:
    dry_friction(double friction_N, double presliding_m) : friction_N_(friction_N), presliding_m_(presliding_m) {}
    void start(const body_motion &motion) override { before_m_ = motion.position_m; }
    bool builds_up() const { return presliding_m_ > 0.0; }
    double force_N(const body_motion &motion, double) override
    {
        if (!builds_up()) {
            const double stops_N = motion.velocity_m_per_s / motion.velocity_per_force;
            return std::min(std::max(stops_N, -friction_N_), friction_N_);
        }
        const double way = motion.position_m - before_m_;
        before_m_ = motion.position_m;
        const double direction = way < 0.0 ? -1.0 : 1.0;
        constexpr double no_more = 45.0; /* exp(-45) is below the rounding of 1, and slow to compute */
        const double ways = std::abs(way) / presliding_m_;
        if (bent_ != direction) {
            bent_ = ways > no_more ? direction : direction + (bent_ - direction) * std::exp(-ways);
        }
        return bent_ * friction_N_;
    }
    bool is_abrupt(double way_m) const override
    {
        constexpr double nearly_full = 0.9999;
        return builds_up() && std::abs(bent_) < nearly_full && way_m > coarse_way * presliding_m_;
    }

  private:
    double friction_N_;
    double presliding_m_;
    double before_m_ = 0.0;
    double bent_ = 0.0;
};

/* Dry friction and presliding way from which a search starts. */
inline std::vector<effect_values> friction_starts(const record_scales &scales)
{
    std::vector<effect_values> all;
    for (const double share : {0.02, 0.15}) {
        for (const double way : {0.0, 1e-5, 5e-4}) {
            all.push_back({share * scales.force_N, way * scales.position_m});
        }
    }
    return all;
}

class cubic_spring final : public force_stage
{
  public:
    explicit cubic_spring(double stiffness_N_per_m3) : stiffness_(stiffness_N_per_m3) {}
    double force_N(const body_motion &motion, double) override
    {
        return stiffness_ * motion.deflection_m * motion.deflection_m * motion.deflection_m;
    }

  private:
    double stiffness_;
};

class quadratic_spring final : public force_stage
{
  public:
    explicit quadratic_spring(double stiffness_N_per_m2) : stiffness_(stiffness_N_per_m2) {}
    double force_N(const body_motion &motion, double) override
    {
        return stiffness_ * motion.deflection_m * motion.deflection_m;
    }

  private:
    double stiffness_;
};

/* What a spring with a gap lacks of one without. */
class spring_gap final : public force_stage
{
  public:
    spring_gap(double stiffness_N_per_m, double half_m) : stiffness_(stiffness_N_per_m), half_m_(half_m) {}
    double force_N(const body_motion &motion, double) override
    {
        return -stiffness_ * std::min(std::max(motion.deflection_m, -half_m_), half_m_);
    }

  private:
    double stiffness_;
    double half_m_;
};

class constant_force final : public force_stage
{
  public:
    explicit constant_force(double force_N) : force_N_(force_N) {}
    double force_N(const body_motion &, double) override { return force_N_; }

  private:
    double force_N_;
};

/* tau y' = u - y, exact where u is straight within the sub-step. */
class first_order_lag final : public motion_stage
{
  public:
    explicit first_order_lag(double lag_s) : lag_s_(lag_s) {}
    void start(double value) override { before_ = output_ = value; }
    double advance(double value, double step_s) override
    {
        const double decay =
            decay_.at(step_s, [this](double h) { return lag_s_ > 0.0 ? std::exp(-h / lag_s_) : 0.0; });
        const double rise = (value - before_) / step_s;
        const double behind = rise * lag_s_; /* of a straight line, for ever */
        const double output = value - behind + (output_ - before_ + behind) * decay;
        /* Of tau r' = u - r, integrated over the step. */
        bulge_ = 0.5 * (before_ + value - output_ - output) - lag_s_ * (output - output_) / step_s;
        output_ = output;
        before_ = value;
        return output_;
    }
    double bulge() const override { return bulge_; }
    double jump(double value) override
    {
        before_ = value;
        return lag_s_ > 0.0 ? output_ : value;
    }

  private:
    double lag_s_;
    by_step<double> decay_;
    double before_ = 0.0;
    double output_ = 0.0;
    double bulge_ = 0.0;
};

} // namespace berth

#endif
