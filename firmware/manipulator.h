/* The simulated manipulator, fixed step, operator command and measured force held constant over it. One degree of
 * freedom,
 *     M x'' + D (x' - v_op) + K (x - x_op) = F_op - F
 * or a whole arm, of which position and velocity are the tool's along the robot's direction. */
#ifndef FIRMWARE_MANIPULATOR_H
#define FIRMWARE_MANIPULATOR_H

#include "arm/arm_motion.h"
#include "config.h"
#include "operator_command.h"

#ifdef __cplusplus
extern "C" {
#endif

struct manipulator {
    double position_m;
    double velocity_m_per_s;
    const struct manipulator_config *config;
    double step_s;        /* period / substeps */
    double transition[4]; /* exact integrator: row-major 2 x 2, state (x, v) over one period */
    double input_map[6];  /* row-major 2 x 3, input (x_op, v_op, F_op - F) over one period */
    uint8_t has_arm;
    struct arm_motion arm; /* if so */
};

/* Prepares the step and puts the manipulator to its initial position and velocity. Keeps a pointer to `config`. */
void manipulator_start(struct manipulator *manipulator, const struct app_config *config);

/* Puts the manipulator to rest at a position. */
void manipulator_rest_at(struct manipulator *manipulator, double position_m);

/* Of the tool beside the loop's direction (enum side_axis): its pose, m or rad, 0 without an arm; what that pose
 * counts as from now on; and what the robot exerts on the object there in the steps to come, N or N m. */
void manipulator_sides(const struct manipulator *manipulator, double side[SIDE_AXIS_COUNT]);
void manipulator_call_sides(struct manipulator *manipulator, const double side[SIDE_AXIS_COUNT]);
void manipulator_load_sides(struct manipulator *manipulator, const double load[SIDE_AXIS_COUNT]);

/* Kinetic, and in its springs; the operator at `operator_position_m`. */
double manipulator_stored_J(const struct manipulator *manipulator, double operator_position_m);

/* One period ahead. `force_N`: what the robot exerts on the object. */
void manipulator_step(struct manipulator *manipulator, const struct operator_command *command, double force_N);

#ifdef __cplusplus
}
#endif
#endif
