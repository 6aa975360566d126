/* An arm on a satellite, as plain values: what an arm file says, compiled to a table. A chain of links with revolute
 * joints; every position and orientation is given in the frame of the body before, as in URDF.
 *
 *     base -> joint 0 -> link 0 -> joint 1 -> ... -> link n-1 -> tool
 *
 * In the plane only x and y, turns about z, and inertia_kg_m2[5] (zz) count. */
#ifndef FIRMWARE_ARM_ARM_CONFIG_H
#define FIRMWARE_ARM_ARM_CONFIG_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define ARM_JOINTS_MAX 7
#define ARM_ANGLE_MAX_rad 1e6 /* as far as sine_and_cosine keeps every digit */
/* By so much the largest principal moment of inertia may exceed the sum of the others, of that sum: makers state
 * moments to two digits, of bodies as slender as links. No body has such moments, and the dynamics take them. */
#define ARM_INERTIA_EXCESS_MAX 0.05

/* ARM_NONE: the manipulator has one degree of freedom. */
enum arm_kind { ARM_NONE, ARM_PLANAR, ARM_SPATIAL, ARM_KIND_COUNT };

enum arm_integrator {
    ARM_SEMI_IMPLICIT_EULER,
    ARM_RK4,
    ARM_IMPLICIT_MIDPOINT, /* in the joints' springs, dampers and servos */
    ARM_INTEGRATOR_COUNT
};

/* What the measured force counts as over a tick. A tick's force is held for it, and comes late by half of it in the
 * mean. */
enum arm_force {
    ARM_FORCE_HELD, /* as it was measured: suits semi-implicit Euler, which is early by half a step by itself */
    ARM_FORCE_LED,  /* led by half a tick, on the line through the last two */
    ARM_FORCE_COUNT
};

struct arm_frame {
    double origin_m[3];
    double axes[9]; /* row-major: columns are the frame's axes as the body before sees them */
};

struct arm_body {
    double mass_kg;
    double centre_m[3];      /* of mass, in the body's frame */
    double inertia_kg_m2[6]; /* about the centre, in the body's axes: xx, xy, xz, yy, yz, zz */
};

/* Motor and link of a joint, coupled by a spring and a damper. Motor values are as the link feels them, behind the
 * gear: an inertia counts with the square of its ratio. */
struct arm_joint {
    struct arm_frame frame; /* where the joint sits, at angle 0 */
    double axis[3];         /* unit, in that frame */
    double stiffness_N_m_per_rad;
    double damping_N_m_s_per_rad;
    double rotor_inertia_kg_m2; /* of the motor itself */
    double gear_ratio;
    double servo_frequency_Hz; /* of the motor's position servo, the motor alone */
    double servo_damping_ratio;
    double torque_limit_N_m; /* of the motor behind the gear */
    double rate_limit_rad_per_s;
    double acceleration_limit_rad_per_s2;
    double angle_min_rad;
    double angle_max_rad;
    double initial_rad;
    struct arm_body link;
};

enum attitude_actuator { ATTITUDE_NONE, ATTITUDE_WHEEL, ATTITUDE_THRUSTERS, ATTITUDE_ACTUATOR_COUNT };

/* Holds the attitude that the base starts with. Every axis by itself. */
struct attitude_config {
    int32_t actuator;             /* enum attitude_actuator */
    int64_t period_ticks;         /* from one look at the error to the next */
    double stiffness_N_m_per_rad; /* wheel */
    double damping_N_m_s_per_rad; /* wheel */
    double torque_limit_N_m;      /* wheel: at most; thrusters: of a pulse */
    double momentum_limit_N_m_s;  /* wheel */
    double deadband_rad;          /* thrusters: of the attitude's error */
    double rate_weight_s;         /* thrusters: rate counts as so much error */
    double on_time_min_ms;        /* thrusters: of a pulse; in whole ticks, as many as it takes */
};

struct arm_config {
    int32_t kind;       /* enum arm_kind */
    int32_t integrator; /* enum arm_integrator */
    int32_t force;      /* enum arm_force */
    int64_t substeps;
    int32_t base_is_free;
    struct arm_body base;
    double base_position_m[3];
    double base_attitude[4]; /* planar: angle in rad, then nothing; spatial: unit quaternion w, x, y, z */
    int64_t joint_count;
    struct arm_joint joints[ARM_JOINTS_MAX];
    struct arm_frame tool;   /* on the last link: where the force acts */
    struct arm_body payload; /* in the tool's frame */
    double gravity_m_per_s2[3];
    struct attitude_config attitude;
};

/* A satellite without an arm: what an arm file does not say. */
struct arm_config arm_default(void);

/* The enum arm_force with which an integrator is accurate: an arm file that says nothing of it has this one. */
int32_t arm_force_for(int32_t integrator);

/* What is wrong with an arm: section and key as in an arm file, and a sentence. key is NULL if nothing is. */
struct arm_error {
    const char *section; /* "joint": of the joint with this number, from 0 */
    int64_t joint;
    const char *key;
    const char *message;
};

struct arm_error arm_validate(const struct arm_config *config);

/* The last of its checks: a joint that turns nothing, a free base that weighs nothing. */
struct arm_error arm_check_inertia(const struct arm_config *config);

#ifdef __cplusplus
}
#endif
#endif
