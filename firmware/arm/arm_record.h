/* The arm in the log: one a tick, beside the tick's own record, where a rig has an arm. */
#ifndef FIRMWARE_ARM_ARM_RECORD_H
#define FIRMWARE_ARM_ARM_RECORD_H

#include <stdint.h>

/* Base in the world: a planar one turns by base_turn_rad; a spatial one is turned as its quaternion says. Joints
 * that an arm does not have are 0. Wheel and thrusters: what the wheel holds, and the torque of a pulse on the base,
 * in the base's axes; a planar arm has those about z alone. guided_by: enum guidance_limit. motors_at_limit: a bit a joint, the first is bit
 * 0: its motor was at its torque limit on the way here. */
#define ARM_RECORD_FIELDS(X)                                                                                        \
    X(uint64_t, timestamp)                                                                                          \
    X(double, base_x_m)                                                                                             \
    X(double, base_y_m)                                                                                             \
    X(double, base_z_m)                                                                                             \
    X(double, base_turn_rad)                                                                                        \
    X(double, base_quaternion_w)                                                                                    \
    X(double, base_quaternion_x)                                                                                    \
    X(double, base_quaternion_y)                                                                                    \
    X(double, base_quaternion_z)                                                                                    \
    X(double, joint_0_rad)                                                                                          \
    X(double, joint_1_rad)                                                                                          \
    X(double, joint_2_rad)                                                                                          \
    X(double, joint_3_rad)                                                                                          \
    X(double, joint_4_rad)                                                                                          \
    X(double, joint_5_rad)                                                                                          \
    X(double, joint_6_rad)                                                                                          \
    X(double, motor_0_rad)                                                                                          \
    X(double, motor_1_rad)                                                                                          \
    X(double, motor_2_rad)                                                                                          \
    X(double, motor_3_rad)                                                                                          \
    X(double, motor_4_rad)                                                                                          \
    X(double, motor_5_rad)                                                                                          \
    X(double, motor_6_rad)                                                                                          \
    X(double, tool_x_m)                                                                                             \
    X(double, tool_y_m)                                                                                             \
    X(double, tool_z_m)                                                                                             \
    X(double, wheel_x_N_m_s)                                                                                        \
    X(double, wheel_y_N_m_s)                                                                                        \
    X(double, wheel_z_N_m_s)                                                                                        \
    X(double, thruster_x_N_m)                                                                                       \
    X(double, thruster_y_N_m)                                                                                       \
    X(double, thruster_z_N_m)                                                                                       \
    X(uint16_t, guided_by)                                                                                          \
    X(uint16_t, motors_at_limit)                                                                                    \
    X(uint32_t, order)

#define ARM_RECORD_MEMBER(type, name) type name;
struct arm_record {
    ARM_RECORD_FIELDS(ARM_RECORD_MEMBER)
};
#undef ARM_RECORD_MEMBER

#endif
