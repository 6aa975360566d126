#include "first_order_limit.h"

#include <cmath>

#include "../../firmware/inverse_filter.h"
#include "../../firmware/pi.h"
#include "../effects/effect.h"
#include "hardware_period.h"
#include "spectrum.h"

namespace berth
{

namespace
{

double robot_delay_s(const rig &rig)
{
    const robot_rig &robot = rig.robot;
    const double dead_time_s = 1e-9 * static_cast<double>(command_to_motion_ns(rig));
    const double lag_s = rig.has_transfer_behaviour()
                             ? 2.0 * robot.transfer_damping_ratio / (two_pi * robot.transfer_frequency_Hz)
                             : 0.0;
    const double held_s = robot.interpolation == interpolation::hold ? 0.5 * config_period_s(&rig.firmware) : 0.0;
    return dead_time_s + lag_s + 1e-3 * value_of(rig, "robot.lag_ms") + held_s;
}

} // namespace

double loop_delay_s(const rig &rig)
{
    const double sample_age_s = 1e-9 * static_cast<double>(hardware_period(rig).sample_age_ns());
    return inverse_filter_delay_s(&rig.firmware) + robot_delay_s(rig) + rig.sensor_low_pass_delay_s() +
           1e-3 * value_of(rig, "sensor.lag_ms") + sample_age_s + config_force_hold_s(&rig.firmware);
}

double first_order_damping_limit(const rig &rig)
{
    const manipulator_config &m = rig.firmware.manipulator;
    const double mass_kg = m.mass_kg + rig.object.mass_kg;
    const double w = std::sqrt((m.stiffness_N_per_m + rig.object.stiffness_N_per_m) / mass_kg);
    if (w == 0.0) {
        return 0.0; /* nothing swings */
    }
    return 0.5 * loop_delay_s(rig) * m.mass_kg / mass_kg * (w - m.stiffness_N_per_m / m.mass_kg / w);
}

double first_order_damping_margin(const rig &rig)
{
    const manipulator_config &m = rig.firmware.manipulator;
    if (m.stiffness_N_per_m + rig.object.stiffness_N_per_m == 0.0) {
        return 1.0;
    }
    return map_point_of(rig).damping_ratio - first_order_damping_limit(rig);
}

} // namespace berth
