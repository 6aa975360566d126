/* Equations of motion of a chain on a free or a held base, with elastic joints. O(n), fixed sizes, the same
 * instructions at every call.
 *
 * Link side: the articulated-body algorithm, Featherstone 2008, chapters 7 and 9.4. Motor side: the rotors turn
 * about their own axes only (Spong 1987), so motor and link of a joint meet in spring and damper alone. */
#ifndef FIRMWARE_ARM_DYNAMICS_H
#define FIRMWARE_ARM_DYNAMICS_H

#include "chain.h"

namespace berth
{

/* Where the bodies are relative to each other. */
template <class Space>
struct chain_pose {
    placement_of<Space> links[ARM_JOINTS_MAX]; /* in the body before */
};

template <class Space>
chain_pose<Space> pose_of(const chain<Space> &chain, const joint_vector &link_rad);

/* The tool's frame in that of the base. */
template <class Space>
placement_of<Space> tool_in_base(const chain<Space> &chain, const chain_pose<Space> &pose);

/* What a joint puts on its link: torque_N_m - armature_kg_m2 * acceleration of the link. */
struct joint_drive {
    joint_vector torque_N_m;
    joint_vector armature_kg_m2;
};

template <class Space>
struct chain_acceleration {
    motion_of<Space> base; /* rate of the twist, in the base's axes */
    joint_vector link_rad_per_s2;
};

/* `state`: position_m and the motors are not looked at. */
template <class Space>
chain_acceleration<Space> forward_dynamics(const chain<Space> &chain, const chain_state<Space> &state,
                                           const joint_drive &drive, const chain_input<Space> &input);

/* Springs, dampers and servos at the middle of a step of `step_s` that starts at `state`, implicit in the
 * accelerations: for a step of 0 they are those at `state` itself. */
struct elastic_joints {
    joint_drive drive;
    joint_vector motor_offset; /* motor acceleration = offset + share * link acceleration */
    joint_vector motor_share;
    std::uint32_t at_limit; /* a bit a joint: its servo asked for more torque than the motor has */

    joint_vector motor_rad_per_s2(const joint_vector &link_rad_per_s2) const
    {
        return motor_offset + motor_share.cwiseProduct(link_rad_per_s2);
    }

    /* Adds its bits to those that are there; `set`: may be null. */
    void note_limits(std::uint32_t *set) const
    {
        if (set != nullptr) {
            *set |= at_limit;
        }
    }
};

/* `offset_s`: how far the command has moved on since the step's start. `motor_rad_per_s2`: an estimate, which tells
 * whether a servo is at its torque limit. */
template <class Space>
elastic_joints drive_joints(const chain<Space> &chain, const chain_state<Space> &state,
                            const chain_input<Space> &input, double step_s, double offset_s,
                            const joint_vector &motor_rad_per_s2);

/* d(state)/dt, all of it, explicit. `at_limit`, if any: takes on the bits of the motors that are at their limits. */
template <class Space>
typename chain_state<Space>::vector derivative(const chain<Space> &chain, const chain_state<Space> &state,
                                               const chain_input<Space> &input, double offset_s,
                                               std::uint32_t *at_limit = nullptr);

/* Twist of the tool in the base's axes = base * twist of the base + joints * joint rates. */
template <class Space>
struct tool_jacobian {
    Eigen::Matrix<double, motion_of<Space>::size, motion_of<Space>::size> base;
    Eigen::Matrix<double, motion_of<Space>::size, ARM_JOINTS_MAX> joints;
};
template <class Space>
tool_jacobian<Space> jacobian_of(const chain<Space> &chain, const chain_pose<Space> &pose);

/* Kinetic energy = 1/2 (V, q')^T [base coupling; coupling^T joints] (V, q'), rotors left out: the
 * composite-rigid-body algorithm. */
template <class Space>
struct chain_inertia {
    inertia_of<Space> base; /* of all, as one body */
    Eigen::Matrix<double, motion_of<Space>::size, ARM_JOINTS_MAX> coupling;
    Eigen::Matrix<double, ARM_JOINTS_MAX, ARM_JOINTS_MAX> joints;
};
template <class Space>
chain_inertia<Space> inertia_of_chain(const chain<Space> &chain, const chain_pose<Space> &pose);

/* Momentum of base, links and wheels about the world's origin, in its axes. */
template <class Space>
wrench_of<Space> momentum(const chain<Space> &chain, const chain_state<Space> &state);

/* Kinetic, elastic (springs and servos without their commands' part) and in J; wheels left out. */
struct chain_energy {
    double kinetic_J;
    double rotors_J;
    double springs_J;
};
template <class Space>
chain_energy energy(const chain<Space> &chain, const chain_state<Space> &state);

} // namespace berth

#endif
