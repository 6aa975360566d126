#include "side_axes.h"

void side_axes_start(struct side_axes *axes, const struct app_config *config)
{
    *axes = (struct side_axes){.config = config->side_axes};
    for (int i = 0; i < SIDE_AXIS_COUNT; i++) {
        axes->any |= config->side_axes[i].enabled != 0;
        limits_start_at(&axes->limits[i], &config->side_axes[i].limits, config_period_s(config), 0.0);
    }
}

void side_axes_limit(struct side_axes *axes, const double wanted[SIDE_AXIS_COUNT], double permitted[SIDE_AXIS_COUNT])
{
    axes->active = 0;
    for (int i = 0; i < SIDE_AXIS_COUNT; i++) {
        permitted[i] = axes->config[i].enabled ? limits_step(&axes->limits[i], wanted[i]) : 0.0;
        axes->active |= axes->limits[i].active;
    }
}

int side_axes_at_rest(const struct side_axes *axes)
{
    int at_rest = 1;
    for (int i = 0; axes->any && i < SIDE_AXIS_COUNT; i++) {
        at_rest &= limits_at_rest(&axes->limits[i]);
    }
    return at_rest;
}

int side_axes_at_place(const struct side_axes *axes, const double reported[SIDE_AXIS_COUNT])
{
    int at_place = 1;
    for (int i = 0; axes->any && i < SIDE_AXIS_COUNT; i++) {
        const double distance = reported[i] - axes->limits[i].position_m;
        const double tolerance = axes->config[i].start_tolerance;
        at_place &= !axes->config[i].enabled || (distance >= -tolerance && distance <= tolerance);
    }
    return at_place;
}

void side_axes_stop(struct side_axes *axes, double rest[SIDE_AXIS_COUNT])
{
    for (int i = 0; i < SIDE_AXIS_COUNT; i++) {
        rest[i] = axes->config[i].enabled ? limits_stop(&axes->limits[i]) : 0.0;
    }
}

void side_record_fill(struct side_record *record, const double manipulator[SIDE_AXIS_COUNT],
                      const double command[SIDE_AXIS_COUNT], const double robot[SIDE_AXIS_COUNT],
                      const double load[SIDE_AXIS_COUNT])
{
    *record = (struct side_record){
        .y_manipulator_m = manipulator[SIDE_AXIS_Y],
        .z_manipulator_m = manipulator[SIDE_AXIS_Z],
        .rx_manipulator_rad = manipulator[SIDE_AXIS_RX],
        .ry_manipulator_rad = manipulator[SIDE_AXIS_RY],
        .rz_manipulator_rad = manipulator[SIDE_AXIS_RZ],
        .y_command_m = command[SIDE_AXIS_Y],
        .z_command_m = command[SIDE_AXIS_Z],
        .rx_command_rad = command[SIDE_AXIS_RX],
        .ry_command_rad = command[SIDE_AXIS_RY],
        .rz_command_rad = command[SIDE_AXIS_RZ],
        .y_robot_m = robot[SIDE_AXIS_Y],
        .z_robot_m = robot[SIDE_AXIS_Z],
        .rx_robot_rad = robot[SIDE_AXIS_RX],
        .ry_robot_rad = robot[SIDE_AXIS_RY],
        .rz_robot_rad = robot[SIDE_AXIS_RZ],
        .y_force_N = load[SIDE_AXIS_Y],
        .z_force_N = load[SIDE_AXIS_Z],
        .rx_torque_N_m = load[SIDE_AXIS_RX],
        .ry_torque_N_m = load[SIDE_AXIS_RY],
        .rz_torque_N_m = load[SIDE_AXIS_RZ],
    };
}
