/* An arm's configuration in the terms of the dynamics, and its state. */
#ifndef FIRMWARE_ARM_CHAIN_H
#define FIRMWARE_ARM_CHAIN_H

#include "arm_config.h"
#include "vectors.h"

namespace berth
{

using joint_vector = Eigen::Matrix<double, ARM_JOINTS_MAX, 1>; /* unused places stay 0 */

template <class Space>
struct chain_joint {
    placement_of<Space> placement; /* at angle 0 */
    motion_of<Space> axis;
    inertia_of<Space> link;
    double stiffness_N_m_per_rad;
    double damping_N_m_s_per_rad;
    double motor_inertia_kg_m2; /* behind the gear */
    double servo_stiffness_N_m_per_rad;
    double servo_damping_N_m_s_per_rad;
    double torque_limit_N_m;
};

template <class Space>
struct chain {
    int joint_count;
    bool base_is_free;
    inertia_of<Space> base;
    chain_joint<Space> joints[ARM_JOINTS_MAX];
    placement_of<Space> tool;
    typename Space::vector gravity_m_per_s2;
};

/* All that moves, in one vector, so that every integrator can add it up. */
template <class Space>
struct chain_state {
    /* Places in the vector. */
    static constexpr int at_position = 0;
    static constexpr int at_attitude = at_position + Space::dimension;
    static constexpr int at_link = at_attitude + Space::attitude_size;
    static constexpr int at_motor = at_link + ARM_JOINTS_MAX;
    static constexpr int at_twist = at_motor + ARM_JOINTS_MAX;
    static constexpr int at_link_rate = at_twist + motion_of<Space>::size;
    static constexpr int at_motor_rate = at_link_rate + ARM_JOINTS_MAX;
    static constexpr int at_wheel = at_motor_rate + ARM_JOINTS_MAX;
    static constexpr int size = at_wheel + Space::turns;

    using vector = Eigen::Matrix<double, size, 1>;
    vector values = vector::Zero();

    template <int Place, int Size>
    auto part()
    {
        return values.template segment<Size>(Place);
    }
    template <int Place, int Size>
    auto part() const
    {
        return values.template segment<Size>(Place);
    }

    /* Origin of the base in the world, m, and its attitude there. */
    auto position_m() { return part<at_position, Space::dimension>(); }
    auto position_m() const { return part<at_position, Space::dimension>(); }
    auto attitude() { return part<at_attitude, Space::attitude_size>(); }
    auto attitude() const { return part<at_attitude, Space::attitude_size>(); }
    auto link_rad() { return part<at_link, ARM_JOINTS_MAX>(); }
    auto link_rad() const { return part<at_link, ARM_JOINTS_MAX>(); }
    auto motor_rad() { return part<at_motor, ARM_JOINTS_MAX>(); }
    auto motor_rad() const { return part<at_motor, ARM_JOINTS_MAX>(); }
    /* Of the base, in its own axes: rad/s, m/s. */
    auto turn_rate() { return part<at_twist, Space::turns>(); }
    auto turn_rate() const { return part<at_twist, Space::turns>(); }
    auto velocity() { return part<at_twist + Space::turns, Space::dimension>(); }
    auto velocity() const { return part<at_twist + Space::turns, Space::dimension>(); }
    auto link_rate() { return part<at_link_rate, ARM_JOINTS_MAX>(); }
    auto link_rate() const { return part<at_link_rate, ARM_JOINTS_MAX>(); }
    auto motor_rate() { return part<at_motor_rate, ARM_JOINTS_MAX>(); }
    auto motor_rate() const { return part<at_motor_rate, ARM_JOINTS_MAX>(); }
    /* Angular momentum of the reaction wheels relative to the base, in its axes, N m s. */
    auto wheel() { return part<at_wheel, Space::turns>(); }
    auto wheel() const { return part<at_wheel, Space::turns>(); }

    motion_of<Space> twist() const { return {turn_rate(), velocity()}; }
    placement_of<Space> base() const { return {position_m(), Space::axes_of(attitude())}; }
};

/* What acts on the arm, held over a step. */
template <class Space>
struct chain_input {
    wrench_of<Space> tool; /* on the tool, about its origin, in the world's axes */
    typename Space::angular wheel_torque_N_m;
    typename Space::angular thruster_torque_N_m; /* both on the base, in its axes */
    joint_vector command_rad; /* of the motors at the start of the step; they move on with the rate */
    joint_vector command_rad_per_s;
};

/* The configuration must have passed arm_validate(). */
template <class Space>
chain<Space> make_chain(const arm_config &config);

/* At rest where the configuration says, springs and servos without load. */
template <class Space>
chain_state<Space> state_at_start(const arm_config &config);

extern template chain<plane> make_chain<plane>(const arm_config &);
extern template chain<space> make_chain<space>(const arm_config &);
extern template chain_state<plane> state_at_start<plane>(const arm_config &);
extern template chain_state<space> state_at_start<space>(const arm_config &);

} // namespace berth

#endif
