#include "setpoint_path.h"

#include <algorithm>

#include "active.h"

namespace berth
{

setpoint_path::setpoint_path(const rig &rig)
    : stages_(active_stages(rig, &effect::on_setpoints)), config_(rig.firmware)
{
    constexpr double huge = 1e9; /* a limit that is not there, and whose square is still finite */
    const double velocity_m_per_s =
        saturates_in_lag(rig) || limits_reference(rig) ? unlimited : rig.robot.velocity_limit_m_per_s;
    is_limited_ = velocity_m_per_s != unlimited || rig.robot.acceleration_limit_m_per_s2 != unlimited;
    config_.limits = {-huge, huge, std::min(huge, velocity_m_per_s),
                      std::min(huge, rig.robot.acceleration_limit_m_per_s2)};
}

double setpoint_path::start(double setpoint_m)
{
    for (auto &stage : stages_) {
        stage->start(setpoint_m);
        setpoint_m = stage->take(setpoint_m);
    }
    config_.manipulator.initial_position_m = setpoint_m;
    limits_start(&limits_, &config_);
    return setpoint_m;
}

double setpoint_path::take(double setpoint_m)
{
    for (auto &stage : stages_) {
        setpoint_m = stage->take(setpoint_m);
    }
    return is_limited_ ? limits_step(&limits_, setpoint_m) : setpoint_m;
}

} // namespace berth
