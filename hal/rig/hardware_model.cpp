#include "hardware_model.h"

#include <cmath>

#include "../../firmware/inverse_filter.h"
#include "../../firmware/pi.h"
#include "keys.h"

namespace berth
{

namespace
{

/* Of an effect that the program knows, else 0; the place of the key is looked up once. */
struct effect_place {
    explicit effect_place(std::string_view path) : key(find_key(path)) {}
    double in(const rig &rig) const { return key != nullptr ? rig.effect_values[key->effect_value] : 0.0; }
    const rig_key *key;
};

void set_lags(hardware_model &model, const rig &rig)
{
    static const effect_place robot_lag("robot.lag_ms");
    static const effect_place sensor_lag("sensor.lag_ms");
    static const effect_place robot_gain("robot.gain_error");
    static const effect_place sensor_gain("sensor.gain_error");
    model.robot_lag_ms = robot_lag.in(rig);
    model.sensor_lag_ms = sensor_lag.in(rig);
    model.robot_gain = 1.0 + robot_gain.in(rig);
    model.sensor_gain = 1.0 + sensor_gain.in(rig);
}

double loop_delay_ms(const hardware_model &model, const rig &rig)
{
    const double period_ms = 1e3 * config_period_s(&rig.firmware);
    const double robot_ms =
        model.robot_w_rad_per_s > 0.0 ? 2e3 * model.robot_damping_ratio / model.robot_w_rad_per_s : 0.0;
    const double held_ms = 1e3 * config_force_hold_s(&rig.firmware) + (model.holds ? 0.5 * period_ms : 0.0);
    const double filter_ms = 1e3 * inverse_filter_delay_s(&rig.firmware); /* less than 0: it compensates robot_ms */
    return filter_ms + model.setpoint_to_motion_ms + robot_ms + model.robot_lag_ms + model.sample_age_ms +
           1e3 * rig.sensor_low_pass_delay_s() + model.sensor_lag_ms + held_ms;
}

} // namespace

hardware_model hardware_model_of(const rig &rig)
{
    hardware_model model{};
    model.setpoint_to_motion_ms = 1e-6 * static_cast<double>(command_to_motion_ns(rig));
    model.sample_age_ms = 1e-6 * static_cast<double>(rig.sample_age_ns());
    const double told_ms = rig.firmware.energy.position_age_ms;
    const double on_the_bus_ms =
        rig.bus.ideal ? 0.0 : 1e3 * config_period_s(&rig.firmware); /* out for the next tick */
    model.report_age_ms = told_ms > 0.0 ? told_ms : on_the_bus_ms;
    model.holds = rig.robot.interpolation == interpolation::hold;
    model.is_one_sided = rig.object.kind == object_kind::contact;
    model.low_pass_order = static_cast<std::int32_t>(rig.sensor.low_pass_order);
    model.low_pass_w_rad_per_s = two_pi * rig.sensor.low_pass_frequency_Hz;
    model.low_pass_damping_ratio = rig.sensor.low_pass_damping_ratio;
    model.robot_w_rad_per_s = rig.has_transfer_behaviour() ? two_pi * rig.robot.transfer_frequency_Hz : 0.0;
    model.robot_damping_ratio = rig.robot.transfer_damping_ratio;
    set_lags(model, rig);
    model.sensor_stiffness_N_per_m = rig.sensor.stiffness_N_per_m;
    model.sensor_damping_N_s_per_m = rig.sensor_damping_N_s_per_m();
    model.mass_kg = rig.object.mass_kg;
    model.damping_N_s_per_m = rig.object.damping_N_s_per_m;
    model.stiffness_N_per_m = rig.object.stiffness_N_per_m;
    model.surface_m = model.is_one_sided ? rig.object.surface_position_m : 0.0;
    model.loop_delay_ms = loop_delay_ms(model, rig);
    return model;
}

} // namespace berth
