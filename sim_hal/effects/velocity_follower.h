/* A reference of straight lines, followed as fast as |r'| <= V permits: at V towards it until there, then along it
 * as long as it is no faster. What comes out is straight lines, too: exact. */
#ifndef SIM_HAL_EFFECTS_VELOCITY_FOLLOWER_H
#define SIM_HAL_EFFECTS_VELOCITY_FOLLOWER_H

#include <cmath>
#include <limits>

#include "stages.h"

namespace berth
{

class velocity_follower
{
  public:
    explicit velocity_follower(double velocity_max_m_per_s) : velocity_max_m_per_s_(velocity_max_m_per_s) {}

    /* Where the reference rests. */
    void start(double goal_m)
    {
        position_m_ = goal_m;
        follow(goal_m, 0.0);
    }

    /* From here on the reference is there, and goes on so fast. */
    void follow(double goal_m, double goal_m_per_s)
    {
        goal_m_ = goal_m;
        goal_m_per_s_ = goal_m_per_s;
        choose();
    }

    double position_m() const { return position_m_; }
    double velocity_m_per_s() const { return velocity_m_per_s_; }

    /* Until it catches up with the reference; infinity where it does not, or is on it. */
    double left_s() const { return left_s_; }

    /* For left_s() at most. */
    void advance(double step_s)
    {
        goal_m_ += goal_m_per_s_ * step_s;
        if (step_s >= left_s_) {
            position_m_ = goal_m_;
            choose();
            return;
        }
        position_m_ = is_on_it_ ? goal_m_ : position_m_ + velocity_m_per_s_ * step_s;
        left_s_ -= step_s;
    }

  private:
    void choose()
    {
        constexpr double there_m = 1e-13; /* rounding, for which no line turns off */
        double error_m = goal_m_ - position_m_;
        error_m = std::abs(error_m) < there_m ? 0.0 : error_m;
        is_on_it_ = error_m == 0.0 && std::abs(goal_m_per_s_) <= velocity_max_m_per_s_;
        const double side = std::copysign(1.0, error_m != 0.0 ? error_m : goal_m_per_s_);
        velocity_m_per_s_ = is_on_it_ ? goal_m_per_s_ : side * velocity_max_m_per_s_;
        const double closing_m_per_s = side * (velocity_m_per_s_ - goal_m_per_s_);
        left_s_ = error_m != 0.0 && closing_m_per_s > 0.0 ? std::abs(error_m) / closing_m_per_s
                                                          : std::numeric_limits<double>::infinity();
    }

    double velocity_max_m_per_s_;
    double goal_m_ = 0.0;
    double goal_m_per_s_ = 0.0;
    double position_m_ = 0.0;
    double velocity_m_per_s_ = 0.0;
    double left_s_ = std::numeric_limits<double>::infinity();
    bool is_on_it_ = true;
};

/* The same of a signal that is straight within a step. */
class limited_velocity final : public motion_stage
{
  public:
    explicit limited_velocity(double velocity_max_m_per_s) : follower_(velocity_max_m_per_s) {}
    void start(double goal_m) override
    {
        goal_m_ = goal_m;
        follower_.start(goal_m);
    }
    double advance(double goal_m, double step_s) override
    {
        follower_.follow(goal_m_, (goal_m - goal_m_) / step_s);
        goal_m_ = goal_m;
        if (follower_.left_s() < step_s) {
            step_s -= follower_.left_s();
            follower_.advance(follower_.left_s());
        }
        follower_.advance(step_s);
        return follower_.position_m();
    }

  private:
    velocity_follower follower_;
    double goal_m_ = 0.0;
};

} // namespace berth

#endif
