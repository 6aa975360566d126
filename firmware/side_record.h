/* The robot's axes beside that of the loop in the log: one a tick, beside the tick's own record, where a rig has
 * such axes. */
#ifndef FIRMWARE_SIDE_RECORD_H
#define FIRMWARE_SIDE_RECORD_H

#include <stdint.h>

/* Of an axis: where the tool is, the setpoint that was sent, where the robot says it is, and the measured load. Axes
 * that a rig does not have are 0, but for where the tool is. */
#define SIDE_RECORD_FIELDS(X)                                                                                       \
    X(uint64_t, timestamp)                                                                                          \
    X(double, y_manipulator_m)                                                                                      \
    X(double, z_manipulator_m)                                                                                      \
    X(double, rx_manipulator_rad)                                                                                   \
    X(double, ry_manipulator_rad)                                                                                   \
    X(double, rz_manipulator_rad)                                                                                   \
    X(double, y_command_m)                                                                                          \
    X(double, z_command_m)                                                                                          \
    X(double, rx_command_rad)                                                                                       \
    X(double, ry_command_rad)                                                                                       \
    X(double, rz_command_rad)                                                                                       \
    X(double, y_robot_m)                                                                                            \
    X(double, z_robot_m)                                                                                            \
    X(double, rx_robot_rad)                                                                                         \
    X(double, ry_robot_rad)                                                                                         \
    X(double, rz_robot_rad)                                                                                         \
    X(double, y_force_N)                                                                                            \
    X(double, z_force_N)                                                                                            \
    X(double, rx_torque_N_m)                                                                                        \
    X(double, ry_torque_N_m)                                                                                        \
    X(double, rz_torque_N_m)

#define SIDE_RECORD_MEMBER(type, name) type name;
struct side_record {
    SIDE_RECORD_FIELDS(SIDE_RECORD_MEMBER)
};
#undef SIDE_RECORD_MEMBER

#endif
