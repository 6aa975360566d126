#include <cmath>

#include "active.h"
#include "effects.h"
#include "force_laws.h"
#include "starts.h"

namespace berth
{

namespace
{

/* tau r' = u - r within |r'| <= V, exact where u is straight within the step: the error runs linearly where the
 * velocity is at its limit, else it decays to that of a straight line. */
class saturated_lag final : public motion_stage
{
  public:
    saturated_lag(double lag_s, double velocity_max_m_per_s)
        : lag_s_(lag_s), velocity_max_m_per_s_(velocity_max_m_per_s)
    {
    }
    void start(double goal_m) override { goal_m_ = position_m_ = goal_m; }
    double jump(double goal_m) override
    {
        goal_m_ = goal_m;
        return position_m_;
    }
    double advance(double goal_m, double step_s) override
    {
        const double goal_m_per_s = (goal_m - goal_m_) / step_s;
        double error_m = goal_m_ - position_m_;
        /* Out of the limit and into it, once each at most: the error turns back at neither. */
        constexpr int phases_max = 3;
        double left_s = step_s;
        for (int i = 0; i < phases_max && left_s > 0.0; i++) {
            left_s -= is_saturated(error_m, goal_m_per_s) ? slew(error_m, goal_m_per_s, left_s)
                                                          : follow(error_m, goal_m_per_s, left_s);
        }
        goal_m_ = goal_m;
        position_m_ = goal_m - error_m;
        return position_m_;
    }

  private:
    double error_max_m() const { return lag_s_ * velocity_max_m_per_s_; }

    /* At the limit, to which side does the error go? */
    bool is_saturated(double error_m, double goal_m_per_s) const
    {
        const double size_m = std::abs(error_m);
        const double growth_m_per_s = std::copysign(1.0, error_m) * goal_m_per_s - velocity_max_m_per_s_;
        return size_m > error_max_m() || (size_m == error_max_m() && growth_m_per_s > 0.0);
    }

    /* Each goes on for left_s, or until the other one begins; returns how long. */
    double slew(double &error_m, double goal_m_per_s, double left_s) const
    {
        const double side = std::copysign(1.0, error_m);
        const double growth_m_per_s = side * goal_m_per_s - velocity_max_m_per_s_;
        const double above_m = std::abs(error_m) - error_max_m();
        if (growth_m_per_s < 0.0 && above_m + growth_m_per_s * left_s < 0.0) {
            error_m = side * error_max_m();
            return above_m / -growth_m_per_s;
        }
        error_m += side * growth_m_per_s * left_s;
        return left_s;
    }
    double follow(double &error_m, double goal_m_per_s, double left_s) const
    {
        const double settled_m = goal_m_per_s * lag_s_;
        const double end_m = settled_m + (error_m - settled_m) * std::exp(-left_s / lag_s_);
        if (std::abs(end_m) <= error_max_m()) {
            error_m = end_m;
            return left_s;
        }
        const double limit_m = std::copysign(error_max_m(), end_m);
        const double until_s = lag_s_ * std::log((error_m - settled_m) / (limit_m - settled_m));
        error_m = limit_m;
        return until_s;
    }

    double lag_s_;
    double velocity_max_m_per_s_;
    double goal_m_ = 0.0;
    double position_m_ = 0.0;
};

} // namespace

effect robot_lag()
{
    effect made;
    made.name = "robot.lag";
    made.physics = "The robot follows like a first-order low-pass: tau r' = u - r; a velocity limit is within it.";
    made.source = "position controllers without feed-forward";
    made.calibration = {6, "time the robot's answer to a step with a recorder much faster than the loop"};
    made.parameters = {{"robot.lag_ms", 0.0, 2000.0, "tau of a first-order lag"}};
    made.look_alike = "robot.dead_time";
    made.starts = [](const rig &, const record_scales &scales) {
        return sizes({1e3 * scales.period_s, 8e3 * scales.period_s, 40.0});
    };
    made.on_motion = [](const rig &rig) -> std::unique_ptr<motion_stage> {
        const double lag_s = 1e-3 * value_of(rig, "robot.lag_ms");
        if (saturates_in_lag(rig)) {
            return std::make_unique<saturated_lag>(lag_s, rig.robot.velocity_limit_m_per_s);
        }
        return std::make_unique<first_order_lag>(lag_s);
    };
    made.when_small = small_motion::in_the_equations;
    return made;
}

} // namespace berth
