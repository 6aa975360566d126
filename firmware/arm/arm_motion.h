/* A whole arm as the loop's manipulator: the robot displays the tool's way along one direction of the world, the
 * measured force acts on the tool against it. So do, where the robot has them, its further axes (enum side_axis). */
#ifndef FIRMWARE_ARM_ARM_MOTION_H
#define FIRMWARE_ARM_ARM_MOTION_H

#include "../operator_command.h"
#include "arm_record.h"
#include "guidance_order.h"

#ifdef __cplusplus
extern "C" {
#endif

#define ARM_MEMORY_BYTES 9920

/* Where the arm lives: fixed matrices, which C has no name for. */
union arm_memory {
    double alignment;
    unsigned char bytes[ARM_MEMORY_BYTES];
};

/* What the robot exerts on the object: along the direction in N, on its further axes in N or N m. */
struct arm_load {
    double force_N;
    double side[SIDE_AXIS_COUNT];
};

struct arm_motion {
    double position_m; /* of the tool along the direction */
    double velocity_m_per_s;
    double stored_J;     /* kinetic, rotors, springs */
    uint8_t has_sides;   /* the robot has further axes: to be set after the start. Else `side` stays as it is */
    uint8_t leads_force; /* see enum arm_force; to be set after the start */
    double side[SIDE_AXIS_COUNT];      /* of the tool in the robot's frame since the start: m, or rad */
    double side_load[SIDE_AXIS_COUNT]; /* as measured there, for the steps to come: N, or N m */
    struct arm_load acting;            /* over the last step */
    struct arm_load measured;          /* before it, ... */
    uint8_t has_measured;              /* ... if there was a step since the arm rested */
    union arm_memory memory;
};

/* At rest where the arm file says; there the position is `position_m`. Keeps a pointer to `arm`. `direction`: in the
 * world, of any length but 0. */
void arm_motion_start(struct arm_motion *motion, const struct arm_config *arm, const double direction[3],
                      double position_m, double period_s);

/* Puts the arm to rest in the shape that it has, which is `position_m` from now on, and forgets its orders. */
void arm_motion_rest_at(struct arm_motion *motion, double position_m);

/* What the tool's pose beside the direction counts as from now on. */
void arm_motion_call_sides(struct arm_motion *motion, const double side[SIDE_AXIS_COUNT]);

/* Takes an order that has been checked. `operator_position_m`: of the operator's command now. */
void arm_motion_take(struct arm_motion *motion, const struct arm_order *order, double operator_position_m);

/* One period ahead. `force_N`: what the robot exerts on the object. */
void arm_motion_step(struct arm_motion *motion, const struct operator_command *command, double force_N);

/* The arm as it is now, for the log. */
void arm_motion_record(const struct arm_motion *motion, struct arm_record *record);

/* How well the tool can be led at the start: below 1 it is too near a singular pose. */
double arm_start_dexterity(const struct arm_config *arm);

#ifdef __cplusplus
}
#endif
#endif
