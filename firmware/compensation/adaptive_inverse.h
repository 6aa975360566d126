/* Motion side: the setpoint with which the robot will be where it is wanted now, from the wanted motion and its
 * derivatives (Chae et al. 2013, Fermandois 2019):
 *     setpoint = a0 x + a1 x' + a2 x'' + ...
 * What is told of the robot gives the coefficients at first: 1 / G(s) as a series, a dead time as its Taylor series.
 * While the loop runs they are corrected by what the robot makes of its setpoints: recursive least squares (Kalman
 * filter of constants) on the setpoint against the motion that the robot reports, both through one and the same
 * band-pass, which also gives the derivatives:
 *     L setpoint = a0 L reported + a1 L reported' + ...
 * What is learnt of a0 counts for the motion about its slow mean: where zero lies teaches nothing of it.
 * Coefficients go three tolerances away and no further. What is known is forgotten only while the motion tells
 * something: at rest and below the noise everything stays.
 * Price: with the derivatives comes the noise of the force; w tau beyond 1 is not a series any more; heavy objects:
 * the acceleration that is fed forward comes back as their force. */
#ifndef FIRMWARE_COMPENSATION_ADAPTIVE_INVERSE_H
#define FIRMWARE_COMPENSATION_ADAPTIVE_INVERSE_H

#include "../config.h"
#include "../past.h"

#ifdef __cplusplus
extern "C" {
#endif

#define INVERSE_TERMS_MAX 6 /* derivatives up to the fifth */

/* What a unit is told. */
struct inverse_settings {
    double period_s;
    uint32_t terms;                      /* of the series that are used */
    double told[INVERSE_TERMS_MAX];      /* a0, a1, ... in s^0, s^1, ...; 0 beyond `terms` */
    double tolerance[INVERSE_TERMS_MAX]; /* of each, one standard deviation; 0: stays as told */
    double bandwidth_Hz;                 /* of the motion that they are fitted to */
    double report_age_ticks;             /* of a reported position when it is used */
    double position_noise_m;             /* of it: standard deviation */
    double memory_s;                     /* greater than 0 */
    double correction_max_m;             /* the setpoint's distance to the wanted position */
};

/* A signal through the band-pass. */
struct inverse_band {
    double slow_m;
    double derivative_m[INVERSE_TERMS_MAX]; /* L x, L x', ... over unit_per_s */
};

struct adaptive_inverse {
    struct inverse_settings settings;
    double noise_squared;                 /* of what a tick tells, m^2 */
    double forgetting;                    /* of what is known, in a tick that tells something */
    double slow_share;                    /* of a tick in the slow mean */
    double unit_per_s[INVERSE_TERMS_MAX]; /* of the band-pass's states: (2 pi bandwidth)^i */
    double transition[INVERSE_TERMS_MAX][INVERSE_TERMS_MAX + 1]; /* of the band-pass, over a tick, state and input */
    struct inverse_band commanded;
    struct inverse_band reported;
    struct past setpoint_m;
    int32_t learns;                                          /* one of the tolerances is not 0 */
    int32_t is_open;                                         /* the bands go on from the tick before */
    double before_m[2];                                      /* what was wanted, newest first */
    double wanted_slow_m;                                    /* its slow mean */
    double covariance[INVERSE_TERMS_MAX][INVERSE_TERMS_MAX]; /* of `share` */
    double share[INVERSE_TERMS_MAX];                         /* tolerances by which the coefficients differ */
    double coefficient[INVERSE_TERMS_MAX];                   /* those that count */
    double error_m;                                          /* what they leave unexplained */
    uint32_t saturated;                                      /* ticks in which correction_max_m acted */
};

/* For the loop's rig: x, x', x'' of a robot with dead time, transfer behaviour and lag. */
struct inverse_settings inverse_settings_of(const struct app_config *config);

/* Enough ticks are kept for the reports' age. */
int adaptive_inverse_fits(const struct app_config *config);

/* Starts at rest at a position. */
void adaptive_inverse_start(struct adaptive_inverse *inverse, const struct inverse_settings *settings,
                            double position_m);

/* As if the wanted position, setpoint and robot had always been there; what was learnt may have been what led here:
 * it counts no more. */
void adaptive_inverse_rest_at(struct adaptive_inverse *inverse, double position_m);

/* Position that is wanted now and its derivatives, as many as there are terms, in m/s^i: the setpoint in m. */
double adaptive_inverse_step(struct adaptive_inverse *inverse, const double *derivatives);

/* The same for three terms, from the position alone: derivatives from its last three ticks. */
double adaptive_inverse_follow(struct adaptive_inverse *inverse, double position_m);

/* Once a tick, after it: the setpoint that has gone out, and where the robot says it is. */
void adaptive_inverse_learn(struct adaptive_inverse *inverse, double setpoint_m, double reported_m);

/* Instead, in a tick in which the robot does not follow the wanted motion. */
void adaptive_inverse_pause(struct adaptive_inverse *inverse);

#ifdef __cplusplus
}
#endif
#endif
