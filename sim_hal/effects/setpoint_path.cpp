#include "setpoint_path.h"

#include <algorithm>
#include <iterator>

#include "active.h"

namespace berth
{

setpoint_path::setpoint_path(const rig &rig) : stages_(active_stages(rig, &effect::on_setpoints))
{
    const double velocity_m_per_s =
        saturates_in_lag(rig) || limits_reference(rig) ? unlimited : rig.robot.velocity_limit_m_per_s;
    if (velocity_m_per_s != unlimited || rig.robot.acceleration_limit_m_per_s2 != unlimited) {
        limits_.emplace(velocity_m_per_s, rig.robot.acceleration_limit_m_per_s2, config_period_s(&rig.firmware));
    }
}

setpoint_path::setpoint_path(const setpoint_path &other) : limits_(other.limits_), position_m_(other.position_m_)
{
    std::transform(other.stages_.begin(), other.stages_.end(), std::back_inserter(stages_),
                   [](const auto &stage) { return stage->copy(); });
}

setpoint_path &setpoint_path::operator=(const setpoint_path &other)
{
    *this = setpoint_path(other);
    return *this;
}

double setpoint_path::start(double setpoint_m)
{
    for (auto &stage : stages_) {
        stage->start(setpoint_m);
        setpoint_m = stage->take(setpoint_m);
    }
    if (limits_) {
        limits_->start(setpoint_m);
    }
    position_m_ = setpoint_m;
    return setpoint_m;
}

double setpoint_path::take(double setpoint_m)
{
    for (auto &stage : stages_) {
        setpoint_m = stage->take(setpoint_m);
    }
    position_m_ = limits_ ? limits_->take(setpoint_m) : setpoint_m;
    return position_m_;
}

double setpoint_path::go_on()
{
    position_m_ = limits_ ? limits_->go_on() : position_m_;
    return position_m_;
}

} // namespace berth
