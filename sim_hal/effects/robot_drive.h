/* The robot between its reference and its tool: transfer behaviour, then effects on its motion. */
#ifndef SIM_HAL_EFFECTS_ROBOT_DRIVE_H
#define SIM_HAL_EFFECTS_ROBOT_DRIVE_H

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "active.h"

namespace berth
{

/* r'' = w^2 (u - r) - 2 z w r', exact where u is straight within a step: r follows the line u - 2 z u'/w, and what
 * is left of the start dies away as a damped oscillation. */
class transfer_behaviour
{
  public:
    explicit transfer_behaviour(const rig &rig)
        : w_(6.28318530717958647692 * rig.robot.transfer_frequency_Hz), z_(rig.robot.transfer_damping_ratio)
    {
    }
    void start(double position_m)
    {
        before_m_ = position_m_ = position_m;
        velocity_m_per_s_ = 0.0;
    }
    double jump(double goal_m)
    {
        before_m_ = goal_m;
        return position_m_;
    }
    double advance(double goal_m, double step_s)
    {
        if (step_s != steps_[0].step_s) {
            if (step_s != steps_[1].step_s) {
                steps_[1] = transition_over(step_s);
            }
            std::swap(steps_[0], steps_[1]);
        }
        const transition &t = steps_[0];
        const double rise = (goal_m - before_m_) / step_s;
        const double behind_m = 2.0 * z_ * rise / w_;
        const double offset_m = position_m_ - (before_m_ - behind_m);
        const double rate = velocity_m_per_s_ - rise;
        position_m_ = goal_m - behind_m + t.a[0] * offset_m + t.a[1] * rate;
        velocity_m_per_s_ = rise + t.a[2] * offset_m + t.a[3] * rate;
        before_m_ = goal_m;
        return position_m_;
    }

  private:
    struct transition {
        double step_s = -1.0;
        double a[4] = {};
    };
    transition transition_over(double step_s) const
    {
        const double under = 1.0 - z_ * z_;
        const double wd = w_ * std::sqrt(std::max(1e-9, std::abs(under)));
        /* exp(-z w h) cosh(wd h) overflows in its parts where the damping is large. */
        const double grow = under > 0.0 ? 0.0 : wd * step_s;
        const double decay = std::exp(-z_ * w_ * step_s + grow);
        const double c = under > 0.0 ? std::cos(wd * step_s) : 0.5 * (1.0 + std::exp(-2.0 * grow));
        const double s = under > 0.0 ? std::sin(wd * step_s) : 0.5 * (1.0 - std::exp(-2.0 * grow));
        return {step_s,
                {decay * (c + z_ * w_ * s / wd), decay * s / wd, -decay * w_ * w_ * s / wd,
                 decay * (c - z_ * w_ * s / wd)}};
    }

    double w_;
    double z_;
    transition steps_[2];
    double before_m_ = 0.0;
    double position_m_ = 0.0;
    double velocity_m_per_s_ = 0.0;
};

class robot_drive
{
  public:
    explicit robot_drive(const rig &rig)
        : has_transfer_(rig.has_transfer_behaviour()), transfer_(rig),
          stages_(active_stages(rig, &effect::on_motion))
    {
    }

    /* At rest with the reference at goal_m; each returns the position of the tool. */
    double start(double goal_m)
    {
        transfer_.start(goal_m);
        for (auto &stage : stages_) {
            stage->start(goal_m);
            goal_m = stage->jump(goal_m);
        }
        return goal_m;
    }

    /* The reference goes straight to goal_m. */
    double advance(double goal_m, double step_s)
    {
        double position_m = has_transfer_ ? transfer_.advance(goal_m, step_s) : goal_m;
        for (auto &stage : stages_) {
            position_m = stage->advance(position_m, step_s);
        }
        return position_m;
    }

    /* The reference is at goal_m all of a sudden. */
    double jump(double goal_m)
    {
        double position_m = has_transfer_ ? transfer_.jump(goal_m) : goal_m;
        for (auto &stage : stages_) {
            position_m = stage->jump(position_m);
        }
        return position_m;
    }

  private:
    bool has_transfer_;
    transfer_behaviour transfer_;
    std::vector<std::unique_ptr<motion_stage>> stages_;
};

} // namespace berth

#endif
