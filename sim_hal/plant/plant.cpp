#include "plant.h"

#include <algorithm>
#include <cmath>

#include "../../firmware/pi.h"
#include "../../hal/rig/beam.h"
#include "../effects/active.h"

namespace berth
{

namespace
{

/* Value of an effect's key; the place of the key is looked up once. */
double effect_value(const rig &rig, const rig_key *key)
{
    return rig.effect_values[key->effect_value];
}
} // namespace

plant::plant(const rig &rig)
    : has_transfer_behaviour(rig.has_transfer_behaviour()), sensor_stiffness_N_per_m(rig.sensor.stiffness_N_per_m),
      sensor_damping_N_s_per_m(rig.sensor_damping_N_s_per_m()), one_sided(rig.object.kind == object_kind::contact),
      mass_kg(rig.object.mass_kg), stiffness_N_per_m(rig.object.stiffness_N_per_m),
      damping_N_s_per_m(rig.object.damping_N_s_per_m), filter_order(rig.sensor.low_pass_order),
      filter_w(two_pi * rig.sensor.low_pass_frequency_Hz), filter_z(rig.sensor.low_pass_damping_ratio)
{
    if (has_transfer_behaviour) {
        robot_w = two_pi * rig.robot.transfer_frequency_Hz;
        robot_z = rig.robot.transfer_damping_ratio;
    }
    if (one_sided) {
        surface_m = rig.object.surface_position_m;
    }
    static const rig_key *const keys[] = {find_key("robot.lag_ms"),
                                          find_key("sensor.lag_ms"),
                                          find_key("object.second_mass_kg"),
                                          find_key("object.second_frequency_Hz"),
                                          find_key("object.second_damping_ratio"),
                                          find_key("sensor.tool_mass_kg"),
                                          find_key("object.relaxation_stiffness_N_per_m"),
                                          find_key("object.relaxation_time_ms")};
    robot_lag_s = 1e-3 * effect_value(rig, keys[0]);
    sensor_lag_s = 1e-3 * effect_value(rig, keys[1]);
    second_mass_kg = effect_value(rig, keys[3]) > 0.0 ? effect_value(rig, keys[2]) : 0.0;
    second_w = two_pi * effect_value(rig, keys[3]);
    second_z = effect_value(rig, keys[4]);
    tool_mass_kg = effect_value(rig, keys[5]);
    relaxation_s = 1e-3 * effect_value(rig, keys[7]);
    relaxation_N_per_m = relaxation_s > 0.0 ? effect_value(rig, keys[6]) : 0.0;
    further_mode_count = static_cast<int>(rig.object.further_mode_count);
    for (int i = 0; i < further_mode_count; i++) {
        const beam_mode of = object_mode(rig.object, i + 1);
        further_modes[static_cast<std::size_t>(i)] = {of.mass_kg, of.damping_N_s_per_m, of.stiffness_N_per_m};
    }
}

template <typename state_type>
state_type plant::natural_scales() const
{
    const double w = std::sqrt(sensor_stiffness_N_per_m / mass_kg);
    const double force_N = sensor_stiffness_N_per_m;
    state_type scales;
    scales.template head<plant_state_count>() << 1.0, w, force_N, force_N * std::max(1.0, filter_w), 1.0,
        std::max(1.0, robot_w), 1.0, std::max(1.0, second_w), 1.0, 1.0, force_N, force_N, 1.0, 1.0;
    if constexpr (has_room_for_beam<state_type>) {
        scales.template tail<beam_state_count - plant_state_count>().setOnes();
        for (int i = 0; i < further_mode_count; i++) {
            const further_mode &own = further_modes[static_cast<std::size_t>(i)];
            const double own_w = std::max(w, std::sqrt(own.stiffness_N_per_m / own.mass_kg));
            scales(further_position(i) + 1) = own_w;
            scales(object_velocity) = std::max(scales(object_velocity), own_w); /* which has part in all */
        }
    }
    return scales;
}

template <typename state_type>
state_type plant::at_rest(double position_m) const
{
    state_type state = state_type::Zero();
    /* k_S (r - x) = k x, of springs in series; a tool in contact starts without touching. */
    double held_N_per_m = stiffness_N_per_m;
    if constexpr (has_room_for_beam<state_type>) {
        for (int i = 0; i < further_mode_count && held_N_per_m > 0.0; i++) {
            held_N_per_m =
                1.0 / (1.0 / held_N_per_m + 1.0 / further_modes[static_cast<std::size_t>(i)].stiffness_N_per_m);
        }
    }
    const double share = one_sided ? 1.0 : sensor_stiffness_N_per_m / (sensor_stiffness_N_per_m + held_N_per_m);
    const double pulled_m = is_held ? position_m - grip_m : 0.0;
    state(object_position) = share * pulled_m;
    const double spring_N = sensor_stiffness_N_per_m * (pulled_m - state(object_position));
    state(filter_output) = filter_order > 0 ? spring_N : 0.0;
    state(robot_position) = has_transfer_behaviour ? position_m : 0.0;
    state(second_position) = second_mass_kg > 0.0 ? state(object_position) : 0.0;
    state(relaxed_position) = relaxation_N_per_m > 0.0 ? state(object_position) : 0.0;
    state(lagged_position) = robot_lag_s > 0.0 ? position_m : 0.0;
    state(lagged_force) = sensor_lag_s > 0.0 ? spring_N : 0.0;
    if constexpr (has_room_for_beam<state_type>) {
        const double force_N = held_N_per_m * state(object_position);
        for (int i = 0; i < further_mode_count && force_N != 0.0; i++) {
            state(further_position(i)) = force_N / further_modes[static_cast<std::size_t>(i)].stiffness_N_per_m;
        }
    }
    return state;
}

template <typename state_type>
void plant::apply_reference_jump(state_type &state, double jump_m) const
{
    if (has_transfer_behaviour || robot_lag_s > 0.0) {
        return;
    }
    if (tool_mass_kg > 0.0) {
        const double pushed_N = filter_w * filter_w * tool_mass_kg * jump_m;
        state(filter_output) += pushed_N;
        state(filter_rate) -= 2.0 * filter_z * filter_w * pushed_N;
    }
    if (!is_held) {
        return;
    }
    const double impulse_N_s = sensor_damping_N_s_per_m * jump_m;
    state(object_velocity) += impulse_N_s / mass_kg;
    if constexpr (has_room_for_beam<state_type>) {
        for (int i = 0; i < further_mode_count; i++) {
            const double kick_m_per_s = impulse_N_s / further_modes[static_cast<std::size_t>(i)].mass_kg;
            state(further_position(i) + 1) += kick_m_per_s;
            state(object_velocity) += kick_m_per_s;
        }
    }
    if (filter_order == 2) {
        state(filter_rate) += filter_w * filter_w * impulse_N_s;
    } else if (filter_order == 1) {
        state(filter_output) += filter_w * impulse_N_s;
    } else if (sensor_lag_s > 0.0) {
        state(lagged_force) += impulse_N_s / sensor_lag_s;
    }
}

template <typename state_type>
void plant::add_linear_effects(state_type &rate, const state_type &state, const reference_line &line,
                               double force_N) const
{
    if (second_mass_kg > 0.0) {
        const double second_N = second_force_N(state);
        rate(object_velocity) += second_N / mass_kg;
        rate(second_position) = state(second_velocity);
        rate(second_velocity) = -second_N / second_mass_kg;
    }
    if (relaxation_N_per_m > 0.0) {
        const double stretched_m = state(object_position) - state(relaxed_position);
        rate(object_velocity) -= relaxation_N_per_m * stretched_m / mass_kg;
        rate(relaxed_position) = stretched_m / relaxation_s;
        rate(fading_behind_relaxed_position) = -state(fading_behind_relaxed_position) / relaxation_s;
    }
    if (tool_mass_kg > 0.0) { /* with y' = filter_rate + w^2 m_T r' no acceleration is needed */
        const double pushed_N_per_s = filter_w * filter_w * tool_mass_kg * robot_velocity_m_per_s(state, line);
        rate(filter_output) += pushed_N_per_s;
        rate(filter_rate) -= 2.0 * filter_z * filter_w * pushed_N_per_s;
    }
    if (robot_lag_s > 0.0) {
        rate(lagged_position) = robot_velocity_m_per_s(state, line);
    }
    if (sensor_lag_s > 0.0) {
        const double filtered_N = filter_order > 0 ? state(filter_output) : force_N;
        rate(lagged_force) = (filtered_N - state(lagged_force)) / sensor_lag_s;
    }
}

/* The first mode is where the tip is less the further ones: what those take of its spring and damper. */
void plant::add_further_modes(beam_state &rate, const beam_state &state, double force_N) const
{
    for (int i = 0; i < further_mode_count; i++) {
        const further_mode &own = further_modes[static_cast<std::size_t>(i)];
        const double q_m = state(further_position(i));
        const double q_m_per_s = state(further_position(i) + 1);
        const double acceleration =
            (force_N - own.damping_N_s_per_m * q_m_per_s - own.stiffness_N_per_m * q_m) / own.mass_kg;
        rate(further_position(i)) = q_m_per_s;
        rate(further_position(i) + 1) = acceleration;
        rate(object_velocity) += acceleration + (stiffness_N_per_m * q_m + damping_N_s_per_m * q_m_per_s) / mass_kg;
    }
}

template plant_state plant::natural_scales() const;
template beam_state plant::natural_scales() const;
template plant_state plant::at_rest(double) const;
template beam_state plant::at_rest(double) const;
template void plant::apply_reference_jump(plant_state &, double) const;
template void plant::apply_reference_jump(beam_state &, double) const;
template void plant::add_linear_effects(plant_state &, const plant_state &, const reference_line &, double) const;
template void plant::add_linear_effects(beam_state &, const beam_state &, const reference_line &, double) const;

} // namespace berth
