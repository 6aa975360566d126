#include "plant.h"

#include <algorithm>
#include <cmath>

namespace berth
{

namespace
{
constexpr double two_pi = 6.28318530717958647692;
}

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
}

plant_state plant::natural_scales() const
{
    const double w = std::sqrt(sensor_stiffness_N_per_m / mass_kg);
    const double force_N = sensor_stiffness_N_per_m;
    plant_state scales;
    scales << 1.0, w, force_N, force_N * std::max(1.0, filter_w), 1.0, std::max(1.0, robot_w);
    return scales;
}

plant_state plant::at_rest(double position_m) const
{
    plant_state state = plant_state::Zero();
    /* k_S (r - x) = k x; a tool in contact starts without touching. */
    const double share = one_sided ? 1.0 : sensor_stiffness_N_per_m / (sensor_stiffness_N_per_m + stiffness_N_per_m);
    state(object_position) = share * position_m;
    state(filter_output) = filter_order > 0 ? sensor_stiffness_N_per_m * (position_m - state(object_position)) : 0.0;
    state(robot_position) = has_transfer_behaviour ? position_m : 0.0;
    return state;
}

contact_mode plant::mode(const plant_state &state) const
{
    return !one_sided || object_force_N(state) > 0.0 ? contact_mode::attached : contact_mode::free;
}

void plant::apply_reference_jump(plant_state &state, double jump_m) const
{
    if (has_transfer_behaviour) {
        return;
    }
    const double impulse_N_s = sensor_damping_N_s_per_m * jump_m;
    state(object_velocity) += impulse_N_s / mass_kg;
    if (filter_order == 2) {
        state(filter_rate) += filter_w * filter_w * impulse_N_s;
    } else if (filter_order == 1) {
        state(filter_output) += filter_w * impulse_N_s;
    }
}

} // namespace berth
