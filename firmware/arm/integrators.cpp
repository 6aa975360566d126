#include "integrators.h"

namespace berth
{

namespace
{

/* Positions of `from` moved on for `step_s` with the velocities of `with`; velocities are those of `from`. The base
 * moves along the axes that it has half-way. */
template <class Space>
chain_state<Space> moved(const chain<Space> &chain, const chain_state<Space> &from, const chain_state<Space> &with,
                         double step_s)
{
    chain_state<Space> result = from;
    if (chain.base_is_free) {
        const typename Space::angular turn = with.turn_rate() * step_s;
        const typename Space::attitude half_way = Space::turned_by(from.attitude(), 0.5 * turn);
        result.attitude() = Space::turned_by(from.attitude(), turn);
        result.position_m() += Space::axes_of(half_way) * (with.velocity() * step_s);
    }
    result.link_rad() += with.link_rate() * step_s;
    result.motor_rad() += with.motor_rate() * step_s;
    return result;
}

/* Velocities of `from` after `step_s` of an acceleration. */
template <class Space>
chain_state<Space> sped_up(const chain_state<Space> &from, const chain_acceleration<Space> &acceleration,
                           const joint_vector &motor_rad_per_s2, double step_s)
{
    chain_state<Space> result = from;
    result.turn_rate() += acceleration.base.angular * step_s;
    result.velocity() += acceleration.base.linear * step_s;
    result.link_rate() += acceleration.link_rad_per_s2 * step_s;
    result.motor_rate() += motor_rad_per_s2 * step_s;
    return result;
}

template <class Space>
chain_state<Space> semi_implicit_euler(const chain<Space> &chain, const chain_state<Space> &state,
                                       const chain_input<Space> &input, double step_s, double offset_s,
                                       std::uint32_t *at_limit)
{
    const elastic_joints joints = drive_joints(chain, state, input, 0.0, offset_s, joint_vector::Zero());
    joints.note_limits(at_limit);
    const chain_acceleration<Space> acceleration = forward_dynamics(chain, state, joints.drive, input);
    const chain_state<Space> faster =
        sped_up(state, acceleration, joints.motor_rad_per_s2(acceleration.link_rad_per_s2), step_s);
    chain_state<Space> result = moved(chain, faster, faster, step_s);
    result.wheel() -= input.wheel_torque_N_m * step_s;
    return result;
}

template <class Space>
chain_state<Space> rk4(const chain<Space> &chain, const chain_state<Space> &state, const chain_input<Space> &input,
                       double step_s, double offset_s, std::uint32_t *at_limit)
{
    const auto rate = [&](const typename chain_state<Space>::vector &values, double after_s) {
        chain_state<Space> at;
        at.values = values;
        at.attitude() = Space::normalised(at.attitude());
        return derivative(chain, at, input, offset_s + after_s, at_limit);
    };
    const double half_s = 0.5 * step_s;
    const typename chain_state<Space>::vector &start = state.values;
    const typename chain_state<Space>::vector k1 = rate(start, 0.0);
    const typename chain_state<Space>::vector k2 = rate(start + half_s * k1, half_s);
    const typename chain_state<Space>::vector k3 = rate(start + half_s * k2, half_s);
    const typename chain_state<Space>::vector k4 = rate(start + step_s * k3, step_s);
    chain_state<Space> result;
    result.values = start + (step_s / 6.0) * (k1 + 2.0 * (k2 + k3) + k4);
    result.attitude() = Space::normalised(result.attitude());
    return result;
}

template <class Space>
chain_state<Space> implicit_midpoint(const chain<Space> &chain, const chain_state<Space> &state,
                                     const chain_input<Space> &input, double step_s, double offset_s,
                                     std::uint32_t *at_limit)
{
    const double half_s = 0.5 * step_s;
    chain_state<Space> middle = state;
    middle.wheel() -= input.wheel_torque_N_m * half_s;
    joint_vector motor_rad_per_s2 = joint_vector::Zero();
    chain_acceleration<Space> acceleration;
    for (int i = 0; i < 2; i++) {
        const elastic_joints joints = drive_joints(chain, state, input, step_s, offset_s, motor_rad_per_s2);
        /* The shape and the velocities are those of the middle; the springs have been taken care of. */
        chain_state<Space> at = moved(chain, state, middle, half_s);
        at.values.template tail<chain_state<Space>::size - chain_state<Space>::at_twist>() =
            middle.values.template tail<chain_state<Space>::size - chain_state<Space>::at_twist>();
        acceleration = forward_dynamics(chain, at, joints.drive, input);
        motor_rad_per_s2 = joints.motor_rad_per_s2(acceleration.link_rad_per_s2);
        const chain_state<Space> faster = sped_up(state, acceleration, motor_rad_per_s2, half_s);
        middle.turn_rate() = faster.turn_rate();
        middle.velocity() = faster.velocity();
        middle.link_rate() = faster.link_rate();
        middle.motor_rate() = faster.motor_rate();
        if (i == 1) {
            joints.note_limits(at_limit);
        }
    }
    chain_state<Space> result = sped_up(moved(chain, state, middle, step_s), acceleration, motor_rad_per_s2, step_s);
    result.wheel() -= input.wheel_torque_N_m * step_s;
    return result;
}

} // namespace

template <class Space>
chain_state<Space> advanced(const chain<Space> &chain, const chain_state<Space> &state,
                            const chain_input<Space> &input, arm_integrator integrator, double step_s,
                            double offset_s, std::uint32_t *at_limit)
{
    switch (integrator) {
    case ARM_SEMI_IMPLICIT_EULER:
        return semi_implicit_euler(chain, state, input, step_s, offset_s, at_limit);
    case ARM_RK4:
        return rk4(chain, state, input, step_s, offset_s, at_limit);
    default:
        return implicit_midpoint(chain, state, input, step_s, offset_s, at_limit);
    }
}

template chain_state<plane> advanced(const chain<plane> &, const chain_state<plane> &, const chain_input<plane> &,
                                     arm_integrator, double, double, std::uint32_t *);
template chain_state<space> advanced(const chain<space> &, const chain_state<space> &, const chain_input<space> &,
                                     arm_integrator, double, double, std::uint32_t *);

} // namespace berth
