/* Laws that more than one block knows. */
#ifndef SIM_HAL_EFFECTS_FORCE_LAWS_H
#define SIM_HAL_EFFECTS_FORCE_LAWS_H

#include <algorithm>
#include <cmath>

#include "effect.h"

namespace berth
{

/* Whatever stops the body within the sub-step, but no more than the friction of its direction: sticking and sliding
 * without a limit velocity. */
class dry_friction final : public force_stage
{
  public:
    dry_friction(double forwards_N, double backwards_N, double forwards_N_s_per_m, double backwards_N_s_per_m)
        : forwards_N_(forwards_N), backwards_N_(backwards_N), forwards_N_s_per_m_(forwards_N_s_per_m),
          backwards_N_s_per_m_(backwards_N_s_per_m)
    {
    }
    double force_N(const body_motion &motion, double) override
    {
        const double v = motion.velocity_m_per_s;
        const double viscous_N = (v > 0.0 ? forwards_N_s_per_m_ : backwards_N_s_per_m_) * v;
        const double stops_N = v / motion.velocity_per_force;
        return viscous_N + std::min(std::max(stops_N, -backwards_N_), forwards_N_);
    }

  private:
    double forwards_N_;
    double backwards_N_;
    double forwards_N_s_per_m_;
    double backwards_N_s_per_m_;
};

inline bool has_asymmetry(const rig &rig)
{
    return value_of(rig, "manipulator.friction_asymmetry_N") != 0.0 ||
           value_of(rig, "manipulator.damping_asymmetry_N_s_per_m") != 0.0;
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
        if (step_s != step_s_) {
            step_s_ = step_s;
            decay_ = lag_s_ > 0.0 ? std::exp(-step_s / lag_s_) : 0.0;
        }
        const double rise = (value - before_) / step_s;
        const double behind = rise * lag_s_; /* of a straight line, for ever */
        output_ = value - behind + (output_ - before_ + behind) * decay_;
        before_ = value;
        return output_;
    }

  private:
    double lag_s_;
    double step_s_ = -1.0;
    double decay_ = 0.0;
    double before_ = 0.0;
    double output_ = 0.0;
};

} // namespace berth

#endif
