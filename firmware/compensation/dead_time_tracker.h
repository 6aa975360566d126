/* How much longer the robot's dead time is than the loop was told, from the positions that it reports: the twin's
 * robot, late by what was told, against the real one. A Kalman filter of one constant: report = twin - longer twin'.
 * The position's age must be told (energy.position_age_ms): that of a report looks like dead time. */
#ifndef FIRMWARE_COMPENSATION_DEAD_TIME_TRACKER_H
#define FIRMWARE_COMPENSATION_DEAD_TIME_TRACKER_H

#include "../config.h"
#include "hardware_twin.h"

#ifdef __cplusplus
extern "C" {
#endif

struct dead_time_tracker {
    int32_t enabled;
    double period_s;
    double delay_ticks;       /* setpoint to report, as told */
    double tolerance_squared; /* s^2 */
    double noise_squared;     /* m^2 */
    double forgetting;
    double lowest_s;
    double highest_s;
    double longer_s;
    double variance; /* s^2 */
    int32_t is_filled;
    struct past robot_m; /* the twin's, without dead time */
};

/* `model`: what the loop was told. */
void dead_time_tracker_start(struct dead_time_tracker *tracker, const struct app_config *config,
                             const struct hardware_model *model);

/* One tick, after the twin's. Returns by how many ticks the robot's dead time is longer. */
double dead_time_tracker_step(struct dead_time_tracker *tracker, const struct hardware_twin *twin,
                              double reported_m);

#ifdef __cplusplus
}
#endif
#endif
