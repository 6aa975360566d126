#include "attitude_control.h"

#include <algorithm>

namespace berth
{

namespace
{

double limited(double value, double limit)
{
    return std::clamp(value, -limit, limit);
}

/* As many as it takes, but for rounding; not negative, and small enough by arm_validate(). */
int32_t whole_above(double value)
{
    constexpr double rounding = 1e-6;
    const auto below = static_cast<int32_t>(value);
    return value - below < rounding ? below : below + 1;
}

/* Torque on the base that the law asks for. */
double wanted_torque(const attitude_config &config, double error_rad, double rate)
{
    return limited(-config.stiffness_N_m_per_rad * error_rad - config.damping_N_m_s_per_rad * rate,
                   config.torque_limit_N_m);
}

/* The wheel takes the opposite, as far as it has room for a tick of it. */
double within_room(const attitude_config &config, double wanted_N_m, double momentum_N_m_s, double period_s)
{
    const double least = std::min((momentum_N_m_s - config.momentum_limit_N_m_s) / period_s, 0.0);
    const double most = std::max((momentum_N_m_s + config.momentum_limit_N_m_s) / period_s, 0.0);
    return std::clamp(wanted_N_m, least, most);
}

} // namespace

template <class Space>
attitude_control<Space> attitude_control_at(const chain_state<Space> &start)
{
    attitude_control<Space> control = {};
    control.wanted = start.attitude();
    control.wheel_wanted_N_m.setZero();
    control.wheel_torque_N_m.setZero();
    control.thruster_torque_N_m.setZero();
    return control;
}

template <class Space>
void attitude_control_step(attitude_control<Space> &control, const attitude_config &config, double period_s,
                           const chain_state<Space> &state)
{
    if (config.actuator == ATTITUDE_NONE) {
        return;
    }
    const bool is_due = control.ticks_to_next == 0;
    control.ticks_to_next = (is_due ? static_cast<int32_t>(config.period_ticks) : control.ticks_to_next) - 1;
    const typename Space::angular error_rad = Space::turn_between(control.wanted, state.attitude());
    for (int axis = 0; axis < Space::turns; axis++) {
        const double rate = state.turn_rate()(axis);
        if (config.actuator == ATTITUDE_WHEEL) {
            if (is_due) {
                control.wheel_wanted_N_m(axis) = wanted_torque(config, error_rad(axis), rate);
            }
            control.wheel_torque_N_m(axis) =
                within_room(config, control.wheel_wanted_N_m(axis), state.wheel()(axis), period_s);
            continue;
        }
        int32_t &ticks = control.pulse_ticks[axis];
        ticks = std::max(ticks - 1, 0);
        if (is_due && ticks == 0) {
            const double error = error_rad(axis) + config.rate_weight_s * rate;
            const int32_t sign = error > config.deadband_rad ? -1 : error < -config.deadband_rad ? 1 : 0;
            control.pulse_sign[axis] = sign;
            ticks = sign == 0 ? 0 : std::max(whole_above(1e-3 * config.on_time_min_ms / period_s), 1);
        }
        control.thruster_torque_N_m(axis) = ticks == 0 ? 0.0 : control.pulse_sign[axis] * config.torque_limit_N_m;
    }
}

template attitude_control<plane> attitude_control_at(const chain_state<plane> &);
template attitude_control<space> attitude_control_at(const chain_state<space> &);
template void attitude_control_step(attitude_control<plane> &, const attitude_config &, double,
                                    const chain_state<plane> &);
template void attitude_control_step(attitude_control<space> &, const attitude_config &, double,
                                    const chain_state<space> &);

} // namespace berth
