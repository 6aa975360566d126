/* Takes away the amplitude error of a robot with the transfer behaviour w^2 / (s^2 + 2 z w s + w^2) in the band
 * below its eigenfrequency: zeros on the robot's poles, new poles at a higher frequency with the damping of a
 * Butterworth filter, unit gain at rest. Price: noise above the band rises by up to (bandwidth/robot)^2. */
#ifndef FIRMWARE_INVERSE_FILTER_H
#define FIRMWARE_INVERSE_FILTER_H

#include "config.h"

#ifdef __cplusplus
extern "C" {
#endif

/* y[n] = b0 u[n] + b1 u[n-1] + b2 u[n-2] - a1 y[n-1] - a2 y[n-2], all in m */
struct inverse_filter {
    double b[3];
    double a[2]; /* a1, a2 */
    double input_m[2];
    double output_m[2];
    int enabled;
};

/* Poles and zeros are matched to the sampled ones, z = exp(s T). Starts at rest at the initial position. */
void inverse_filter_start(struct inverse_filter *filter, const struct app_config *config);

/* Forgets the past: as if the position had always been `position_m`. */
void inverse_filter_rest_at(struct inverse_filter *filter, double position_m);

/* One tick: wanted position in, corrected position out, in m. Passes through if not enabled. */
double inverse_filter_step(struct inverse_filter *filter, double wanted_m);

/* By which slow signals leave it later than they came; negative: earlier. 0 if not enabled. */
double inverse_filter_delay_s(const struct app_config *config);

#ifdef __cplusplus
}
#endif
#endif
