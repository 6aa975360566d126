#include "arm_config.h"

#include <math.h>
#include <stddef.h>

/* Sizes beyond which products of them leave what a double can hold, or sums what it can tell apart. */
#define LARGEST 1e12
#define FARTHEST_m 1e6

static const struct arm_error no_error = {NULL, 0, NULL, NULL};

/* Neither infinite nor no number, too. */
static int are_within(const double *values, int count, double most)
{
    for (int i = 0; i < count; i++) {
        if (!(fabs(values[i]) <= most)) {
            return 0;
        }
    }
    return 1;
}

static int is_finite_all(const double *values, int count)
{
    for (int i = 0; i < count; i++) {
        if (!isfinite(values[i])) {
            return 0;
        }
    }
    return 1;
}

int32_t arm_force_for(int32_t integrator)
{
    return integrator == ARM_SEMI_IMPLICIT_EULER ? ARM_FORCE_HELD : ARM_FORCE_LED;
}

struct arm_config arm_default(void)
{
    struct arm_config config = {
        .kind = ARM_SPATIAL,
        .integrator = ARM_IMPLICIT_MIDPOINT,
        .force = arm_force_for(ARM_IMPLICIT_MIDPOINT),
        .substeps = 1,
        .base_is_free = 1,
        .tool = {.axes = {1, 0, 0, 0, 1, 0, 0, 0, 1}},
        .attitude = {.period_ticks = 1},
    };
    return config;
}

/* A symmetric matrix, xx, xy, xz, yy, yz, zz, plus `added` on the diagonal has no negative direction: no principal
 * minor below 0. `size`: of its entries, for what rounding makes of 0. */
static int has_no_negative_direction(const double a[6], double added, double size)
{
    const double rounding = 1e-6 * size;
    const double xx = a[0] + added;
    const double yy = a[3] + added;
    const double zz = a[5] + added;
    const double least_minor = -rounding * size;
    const double determinant =
        xx * yy * zz + 2.0 * a[1] * a[2] * a[4] - xx * a[4] * a[4] - yy * a[2] * a[2] - zz * a[1] * a[1];
    return xx >= -rounding && yy >= -rounding && zz >= -rounding && xx * yy - a[1] * a[1] >= least_minor &&
           xx * zz - a[2] * a[2] >= least_minor && yy * zz - a[4] * a[4] >= least_minor &&
           determinant >= least_minor * size;
}

/* An inertia has no negative direction, and neither has the second moment of mass, trace / 2 - I: there the smallest
 * moment is (a + b - c) / 2 of principal moments a, b and c, half the trace (a + b + c) / 2. What is allowed of
 * c / (a + b) - 1 is added to it. */
static int is_inertia(const double i[6])
{
    const double half = 0.5 * (i[0] + i[3] + i[5]);
    const double moment[6] = {half - i[0], -i[1], -i[2], half - i[3], -i[4], half - i[5]};
    const double allowed = half * ARM_INERTIA_EXCESS_MAX / (2.0 + ARM_INERTIA_EXCESS_MAX);
    return half >= 0.0 && has_no_negative_direction(i, 0.0, half) &&
           has_no_negative_direction(moment, allowed, half);
}

static struct arm_error check_body(const struct arm_body *body, const char *section, int64_t joint, int is_planar)
{
    const struct arm_error wrong_mass = {section, joint, "mass_kg", "must be 0 or more"};
    const struct arm_error no_mass = {
        section, joint, "mass_kg", "is missing, or 0, and yet there are moments of inertia; state both or neither"};
    const struct arm_error too_heavy = {section, joint, "mass_kg", "must be 1e12 at most"};
    const struct arm_error too_far = {section, joint, "centre_m", "must be 1e6 m away at most"};
    const struct arm_error too_hard_to_turn = {section, joint, "inertia_kg_m2", "must be 1e18 at most"};
    const struct arm_error wrong_centre = {section, joint, "centre_m", "must be finite"};
    const struct arm_error wrong_turning = {section, joint, "inertia_kg_m2",
                                            "zz must be 0 or more, about the centre of mass"};
    const struct arm_error wrong_inertia = {section, joint, "inertia_kg_m2",
                                            "no body has it: about the centre of mass no principal moment may be "
                                            "negative, or larger than the sum of the "
                                            "others by more than 5 %"};
    if (!(body->mass_kg >= 0.0 && isfinite(body->mass_kg))) {
        return wrong_mass;
    }
    if (body->mass_kg > LARGEST) {
        return too_heavy;
    }
    if (!is_finite_all(body->centre_m, 3)) {
        return wrong_centre;
    }
    if (!are_within(body->centre_m, 3, FARTHEST_m)) {
        return too_far;
    }
    if (!is_finite_all(body->inertia_kg_m2, 6)) {
        return wrong_inertia;
    }
    if (!are_within(body->inertia_kg_m2, 6, 1e18)) {
        return too_hard_to_turn;
    }
    if (body->mass_kg == 0.0 && !are_within(body->inertia_kg_m2, 6, 0.0)) {
        return no_mass;
    }
    if (is_planar) {
        return body->inertia_kg_m2[5] >= 0.0 ? no_error : wrong_turning;
    }
    return is_inertia(body->inertia_kg_m2) ? no_error : wrong_inertia;
}

static int is_frame(const struct arm_frame *frame, int is_planar)
{
    const double *a = frame->axes;
    if (!is_finite_all(frame->origin_m, 3) || !is_finite_all(a, 9)) {
        return 0;
    }
    for (int i = 0; i < 3; i++) {
        for (int j = i; j < 3; j++) {
            const double product = a[i] * a[j] + a[3 + i] * a[3 + j] + a[6 + i] * a[6 + j];
            if (fabs(product - (i == j ? 1.0 : 0.0)) > 1e-9) {
                return 0;
            }
        }
    }
    return !is_planar || fabs(a[8] - 1.0) < 1e-9;
}

struct value_check {
    const char *key;
    size_t offset;
    int zero_is_allowed;
    int infinity_is_allowed;
    double least; /* but for 0 */
    double most;  /* but for infinity */
    const char *range;
};

#define JOINT_VALUE(member, zero_is_allowed, infinity_is_allowed, least, most)                                      \
    {                                                                                                               \
#member, offsetof(struct arm_joint, member), zero_is_allowed, infinity_is_allowed, least, most,             \
            "must be from " #least " to " #most                                                                     \
    }

static const struct value_check joint_checks[] = {
    JOINT_VALUE(stiffness_N_m_per_rad, 0, 0, 1e-6, 1e12),
    JOINT_VALUE(damping_N_m_s_per_rad, 1, 0, 1e-12, 1e12),
    JOINT_VALUE(rotor_inertia_kg_m2, 0, 0, 1e-12, 1e9),
    JOINT_VALUE(gear_ratio, 0, 0, 1e-3, 1e6),
    JOINT_VALUE(servo_frequency_Hz, 1, 0, 1e-6, 1e6),
    JOINT_VALUE(servo_damping_ratio, 1, 0, 1e-6, 1e6),
    JOINT_VALUE(torque_limit_N_m, 0, 1, 1e-9, 1e12),
    JOINT_VALUE(rate_limit_rad_per_s, 0, 1, 1e-9, 1e9),
    JOINT_VALUE(acceleration_limit_rad_per_s2, 0, 1, 1e-9, 1e12),
};

static struct arm_error check_joint(const struct arm_joint *joint, int64_t number, int is_planar)
{
    const struct arm_error wrong_frame = {"joint", number, "rpy_rad",
                                          is_planar ? "a planar arm turns about z alone" : "must be finite"};
    const struct arm_error too_far = {"joint", number, "origin_m", "must be 1e6 m away at most"};
    const struct arm_error wrong_axis = {"joint", number, "axis",
                                         is_planar ? "of a planar arm must be [0, 0, 1] or [0, 0, -1]"
                                                   : "must be a direction, its length 1"};
    const struct arm_error wrong_range = {"joint", number, "angle_max_rad", "must be greater than angle_min_rad"};
    const struct arm_error wrong_start = {"joint", number, "initial_rad",
                                          "must be from angle_min_rad to angle_max_rad"};
    const struct arm_error too_many_turns = {"joint", number, "initial_rad", "must be within 1e6 rad"};
    if (!is_frame(&joint->frame, is_planar)) {
        return wrong_frame;
    }
    if (!are_within(joint->frame.origin_m, 3, FARTHEST_m)) {
        return too_far;
    }
    const double *axis = joint->axis;
    const double square = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
    if (!(fabs(square - 1.0) < 1e-9) || (is_planar && !(fabs(fabs(axis[2]) - 1.0) < 1e-9))) {
        return wrong_axis;
    }
    for (size_t i = 0; i < sizeof joint_checks / sizeof joint_checks[0]; i++) {
        const struct value_check *check = &joint_checks[i];
        const double value = *(const double *)((const char *)joint + check->offset);
        if (!(check->zero_is_allowed ? value >= 0.0 : value > 0.0)) {
            return (struct arm_error){"joint", number, check->key,
                                      check->zero_is_allowed ? "must be 0 or more"
                                                             : "is missing, or not greater than 0"};
        }
        if (!check->infinity_is_allowed && !isfinite(value)) {
            return (struct arm_error){"joint", number, check->key, "must be finite"};
        }
        if (value != 0.0 && isfinite(value) && !(value >= check->least && value <= check->most)) {
            return (struct arm_error){"joint", number, check->key, check->range};
        }
    }
    if (!(joint->angle_max_rad > joint->angle_min_rad)) {
        return wrong_range;
    }
    if (!(joint->initial_rad >= joint->angle_min_rad && joint->initial_rad <= joint->angle_max_rad)) {
        return wrong_start;
    }
    if (!(fabs(joint->initial_rad) <= ARM_ANGLE_MAX_rad)) {
        return too_many_turns;
    }
    return check_body(&joint->link, "joint.link", number, is_planar);
}

static struct arm_error check_attitude(const struct arm_config *config)
{
    const struct attitude_config *attitude = &config->attitude;
    const double values[] = {attitude->stiffness_N_m_per_rad, attitude->damping_N_m_s_per_rad,
                             attitude->torque_limit_N_m,      attitude->momentum_limit_N_m_s,
                             attitude->deadband_rad,          attitude->rate_weight_s,
                             attitude->on_time_min_ms};
    static const char *const keys[] = {"stiffness_N_m_per_rad", "damping_N_m_s_per_rad", "torque_limit_N_m",
                                       "momentum_limit_N_m_s",  "deadband_rad",          "rate_weight_s",
                                       "on_time_min_ms"};
    static const int is_limit[] = {0, 0, 1, 1, 1, 0, 0}; /* may be infinite */
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
        if (!(values[i] >= 0.0)) {
            return (struct arm_error){"attitude", 0, keys[i], "must be 0 or more"};
        }
        if (values[i] > LARGEST && !(is_limit[i] && isinf(values[i]))) {
            return (struct arm_error){"attitude", 0, keys[i], "must be 1e12 at most"};
        }
    }
    const int is_wheel = attitude->actuator == ATTITUDE_WHEEL;
    if (attitude->actuator != ATTITUDE_NONE && !(attitude->torque_limit_N_m > 0.0)) {
        return (struct arm_error){"attitude", 0, "torque_limit_N_m",
                                  "is missing, or 0: the actuator would never act"};
    }
    if (is_wheel && !(attitude->momentum_limit_N_m_s > 0.0)) {
        return (struct arm_error){"attitude", 0, "momentum_limit_N_m_s",
                                  "is missing, or 0: the wheel would never act; inf if it knows no limit"};
    }
    if (attitude->actuator == ATTITUDE_THRUSTERS && isinf(attitude->torque_limit_N_m)) {
        return (struct arm_error){"attitude", 0, "torque_limit_N_m", "must be finite: thrusters give all of it"};
    }
    if (attitude->on_time_min_ms > 60000.0) {
        return (struct arm_error){"attitude", 0, "on_time_min_ms", "must be at most a minute"};
    }
    if (attitude->period_ticks < 1 || attitude->period_ticks > 1000000) {
        return (struct arm_error){"attitude", 0, "period_ticks", "must be from 1 to 1000000"};
    }
    if (attitude->actuator != ATTITUDE_NONE && !config->base_is_free) {
        return (struct arm_error){"attitude", 0, "actuator", "must be \"none\" for a base that is held"};
    }
    return no_error;
}

struct arm_error arm_validate(const struct arm_config *config)
{
    const int is_planar = config->kind == ARM_PLANAR;
    if (config->joint_count < 1 || config->joint_count > ARM_JOINTS_MAX) {
        return (struct arm_error){"joint", 0, "", "there must be 1 to 7 of them"};
    }
    if (config->substeps < 1 || config->substeps > 1000) {
        return (struct arm_error){"substeps", 0, "", "must be from 1 to 1000"};
    }
    if (!are_within(config->base_position_m, 3, FARTHEST_m)) {
        return (struct arm_error){"base", 0, "position_m", "must be finite, and 1e6 m away at most"};
    }
    if (!are_within(config->gravity_m_per_s2, 3, 1e6)) {
        return (struct arm_error){"base", 0, "gravity_m_per_s2", "must be finite, and 1e6 at most"};
    }
    const double *q = config->base_attitude;
    if (is_planar ? !(fabs(q[0]) <= ARM_ANGLE_MAX_rad)
                  : !(fabs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1.0) < 1e-9)) {
        return (struct arm_error){"base", 0, is_planar ? "turn_rad" : "quaternion",
                                  is_planar ? "must be within 1e6 rad; leave whole turns out"
                                            : "must have length 1"};
    }
    struct arm_error error = check_body(&config->base, "base", 0, is_planar);
    for (int64_t i = 0; i < config->joint_count && error.key == NULL; i++) {
        error = check_joint(&config->joints[i], i, is_planar);
    }
    if (error.key == NULL && !is_frame(&config->tool, is_planar)) {
        error = (struct arm_error){"tool", 0, "rpy_rad", "a planar arm turns about z alone"};
    }
    if (error.key == NULL && !are_within(config->tool.origin_m, 3, FARTHEST_m)) {
        error = (struct arm_error){"tool", 0, "origin_m", "must be 1e6 m away at most"};
    }
    if (error.key == NULL) {
        error = check_body(&config->payload, "payload", 0, is_planar);
    }
    if (error.key == NULL) {
        error = check_attitude(config);
    }
    if (error.key == NULL) {
        error = arm_check_inertia(config);
    }
    return error;
}
