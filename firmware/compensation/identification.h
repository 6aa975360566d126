/* What the object has that the model does not know of: shares of its mass, damping and stiffness, by recursive least
 * squares from what the measured force shows beyond the twin's (Kalman filter of three constants; contact identified
 * while it lasts as in Li et al. 2026).
 *
 *     error = dm LP[x''] + c (dd LP[x'] + dk LP[x])      c: 1 where it touches, LP: the sensor's low-pass
 *
 * What is known beforehand (the tolerance) holds them where a motion tells nothing, as mass and stiffness apart from
 * each other at a single frequency. */
#ifndef FIRMWARE_COMPENSATION_IDENTIFICATION_H
#define FIRMWARE_COMPENSATION_IDENTIFICATION_H

#include "../config.h"
#include "hardware_twin.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { IDENTIFIED_MASS, IDENTIFIED_DAMPING, IDENTIFIED_STIFFNESS, IDENTIFIED_COUNT };

struct identification {
    int32_t enabled;
    double period_s;
    double scales[IDENTIFIED_COUNT]; /* kg, N s/m, N/m that a share of 1 stands for */
    double lowest[IDENTIFIED_COUNT]; /* shares with which the object stays passive */
    double highest;
    double tolerance_squared;
    double noise_squared;
    double forgetting; /* of what is known, in a tick */

    double low_pass[2][3];                /* over a tick: state and what goes in to state */
    double filtered[IDENTIFIED_COUNT][2]; /* LP of each force at a share of 1, N, and its rate */
    double velocity_m_per_s;              /* of the object one tick ago ... */
    double touching[IDENTIFIED_COUNT];    /* ... and its forces at a share of 1 then, N */
    double delay_ticks;
    struct past past_N[IDENTIFIED_COUNT];

    double share[IDENTIFIED_COUNT];
    double covariance[IDENTIFIED_COUNT][IDENTIFIED_COUNT];
};

/* `model`: what is known beforehand. */
void identification_start(struct identification *identification, const struct app_config *config,
                          const struct hardware_model *model);

/* One tick, after the twin's: takes the error of the force sample and returns what is left of it, in N.
 * `longer_ticks`: see dead_time_tracker.h. */
double identification_step(struct identification *identification, const struct hardware_twin *twin,
                           double longer_ticks, double error_N);

/* The force that belongs to a motion beyond the model's, in N. */
double identification_force(const struct identification *identification, const struct hardware_model *model,
                            double depth_m, double velocity_m_per_s, double acceleration_m_per_s2);

#ifdef __cplusplus
}
#endif
#endif
