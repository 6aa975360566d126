/* A drive that goes from setpoint to setpoint as fast as |r'| <= V and |r''| <= A permit: along with the setpoints,
 * and on top of their velocity no more than can be braked away until the gap is closed. */
#ifndef SIM_HAL_EFFECTS_DRIVE_LIMITS_H
#define SIM_HAL_EFFECTS_DRIVE_LIMITS_H

#include <algorithm>
#include <cmath>

namespace berth
{

class drive_limits
{
  public:
    /* Neither limit need be there: infinity. */
    drive_limits(double velocity_max_m_per_s, double acceleration_max_m_per_s2, double period_s)
        : velocity_max_m_per_s_(velocity_max_m_per_s), change_m_per_s_(acceleration_max_m_per_s2 * period_s),
          period_s_(period_s)
    {
    }

    /* At rest on a setpoint. */
    void start(double setpoint_m)
    {
        setpoint_m_ = position_m_ = setpoint_m;
        velocity_m_per_s_ = 0.0;
    }

    /* The next setpoint: returns where the drive is when it ought to be there. */
    double take(double setpoint_m)
    {
        const double wish = wished_velocity(setpoint_m);
        const double velocity = std::clamp(std::clamp(wish, -velocity_max_m_per_s_, velocity_max_m_per_s_),
                                           velocity_m_per_s_ - change_m_per_s_, velocity_m_per_s_ + change_m_per_s_);
        const bool arrives = velocity == wish && is_near(setpoint_m_);
        const double position_m = arrives ? setpoint_m : position_m_ + velocity * period_s_;
        velocity_m_per_s_ = velocity;
        position_m_ = position_m;
        setpoint_m_ = setpoint_m;
        return position_m;
    }

    /* A period without a new setpoint: it does not stop at once. */
    double go_on() { return take(setpoint_m_); }

  private:
    /* One period's change of velocity closes the gap. */
    bool is_near(double goal_m) const { return std::abs(goal_m - position_m_) <= change_m_per_s_ * period_s_; }

    double wished_velocity(double setpoint_m) const
    {
        if (is_near(setpoint_m_)) {
            return (setpoint_m - position_m_) / period_s_;
        }
        const double gap_m = setpoint_m_ - position_m_;
        return (setpoint_m - setpoint_m_) / period_s_ + std::copysign(stopping_speed(std::abs(gap_m)), gap_m);
    }

    /* From which the drive stops within the distance: at k periods before its end there are A T^2 k (k + 1) / 2 left
     * and the speed is A T k. With T to 0 it is the square root of 2 A d. */
    double stopping_speed(double distance_m) const
    {
        const double half = 0.5 * change_m_per_s_;
        return std::sqrt(half * half + 2.0 * change_m_per_s_ / period_s_ * distance_m) - half;
    }

    double velocity_max_m_per_s_;
    double change_m_per_s_;
    double period_s_;
    double setpoint_m_ = 0.0;
    double position_m_ = 0.0;
    double velocity_m_per_s_ = 0.0;
};

} // namespace berth

#endif
