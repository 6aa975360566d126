/* The robot between its reference and its tool: transfer behaviour, then effects on its motion. */
#ifndef SIM_HAL_EFFECTS_ROBOT_DRIVE_H
#define SIM_HAL_EFFECTS_ROBOT_DRIVE_H

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "active.h"
#include "by_step.h"

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
        bulge_m_ = 0.0;
    }
    double jump(double goal_m)
    {
        before_m_ = goal_m;
        return position_m_;
    }
    double advance(double goal_m, double step_s)
    {
        const transition &a = transitions_.at(step_s, [this](double h) { return transition_over(h); });
        const double rise = (goal_m - before_m_) / step_s;
        const double behind_m = 2.0 * z_ * rise / w_;
        const double offset_m = position_m_ - (before_m_ - behind_m);
        const double rate = velocity_m_per_s_ - rise;
        const double position_m = goal_m - behind_m + a[0] * offset_m + a[1] * rate;
        const double velocity_m_per_s = rise + a[2] * offset_m + a[3] * rate;
        /* Of its equation, integrated over the step. */
        const double lag_m_s =
            ((velocity_m_per_s - velocity_m_per_s_) / w_ + 2.0 * z_ * (position_m - position_m_)) / w_;
        bulge_m_ = 0.5 * (before_m_ + goal_m - position_m_ - position_m) - lag_m_s / step_s;
        position_m_ = position_m;
        velocity_m_per_s_ = velocity_m_per_s;
        before_m_ = goal_m;
        return position_m_;
    }

    /* By how much its way over the last step was beside a straight line, in the mean. */
    double bulge_m() const { return bulge_m_; }

  private:
    using transition = std::array<double, 4>;

    transition transition_over(double step_s) const
    {
        const double under = 1.0 - z_ * z_;
        const double wd = w_ * std::sqrt(std::max(1e-9, std::abs(under)));
        /* exp(-z w h) cosh(wd h) overflows in its parts where the damping is large. */
        const double grow = under > 0.0 ? 0.0 : wd * step_s;
        const double decay = std::exp(-z_ * w_ * step_s + grow);
        const double c = under > 0.0 ? std::cos(wd * step_s) : 0.5 * (1.0 + std::exp(-2.0 * grow));
        const double s = under > 0.0 ? std::sin(wd * step_s) : 0.5 * (1.0 - std::exp(-2.0 * grow));
        return {decay * (c + z_ * w_ * s / wd), decay * s / wd, -decay * w_ * w_ * s / wd,
                decay * (c - z_ * w_ * s / wd)};
    }

    double w_;
    double z_;
    by_step<transition> transitions_;
    double before_m_ = 0.0;
    double position_m_ = 0.0;
    double velocity_m_per_s_ = 0.0;
    double bulge_m_ = 0.0;
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
    double start(double goal_m) { return start(goal_m, goal_m); }

    /* The same of a tool that was seen at seen_m. */
    double start(double goal_m, double seen_m)
    {
        transfer_.start(goal_m);
        for (auto &stage : stages_) {
            stage->start_seen(goal_m, seen_m);
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

    /* Of the tool's last step: see motion_stage. What follows a corner in the drive has not seen it. */
    double bulge_m() const { return stages_.empty() ? own_bulge_m() : stages_.back()->bulge(); }

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
    double own_bulge_m() const { return has_transfer_ ? transfer_.bulge_m() : 0.0; }

    bool has_transfer_;
    transfer_behaviour transfer_;
    std::vector<std::unique_ptr<motion_stage>> stages_;
};

} // namespace berth

#endif
