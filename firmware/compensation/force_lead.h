/* Force side: the measured force, brought forward over its age with what the object's model says of the way that the
 * manipulator has gone since (force lead; a Smith predictor whose hardware is a pure delay):
 *     F_used = Q (F_measured - F_model(then)) + F_model(over the coming tick),   F_model = k x + d x' + m x''
 * Q: first-order low-pass, or 1. What is wrong with the model counts only as far as its force changes in that time.
 * It takes the robot to be where the manipulator is: what is on the motion side sees to that. */
#ifndef FIRMWARE_COMPENSATION_FORCE_LEAD_H
#define FIRMWARE_COMPENSATION_FORCE_LEAD_H

#include "../config.h"
#include "../past.h"

#ifdef __cplusplus
extern "C" {
#endif

struct force_lead_settings {
    double period_s;
    struct hardware_model model; /* its object counts; a tool pushes only where it touches */
    double age_ticks;            /* of the measured force when it is used */
    double bandwidth_Hz;         /* of Q; not finite: 1 */
    double force_max_N;          /* of what is used */
};

struct force_lead {
    struct force_lead_settings settings;
    double error_share; /* of a new error in what counts */
    int32_t is_filled;
    struct past model_N;
    double error_N; /* measured less model, then */
    double fed_back_N;
    uint32_t saturated; /* ticks in which force_max_N acted */
};

/* Of now; the position counts from where the object's spring is slack. */
struct force_lead_motion {
    double position_m;
    double velocity_m_per_s;
    double acceleration_m_per_s2;
    double jerk_m_per_s3;
};

/* For the loop's rig. */
struct force_lead_settings force_lead_settings_of(const struct app_config *config);

/* Enough ticks are kept for the age. */
int force_lead_fits(const struct app_config *config);

void force_lead_start(struct force_lead *lead, const struct force_lead_settings *settings);

/* Forgets the past. */
void force_lead_rest(struct force_lead *lead);

/* One tick: the force for the coming step, in N. */
double force_lead_step(struct force_lead *lead, const struct force_lead_motion *motion, double measured_N);

#ifdef __cplusplus
}
#endif
#endif
