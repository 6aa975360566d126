/* Which part of the loop's dead time each unit makes up for, where its rig file does not tell: no part twice.
 *
 *     robot   dead time, transfer behaviour, lag      adaptive inverse; else extrapolation; else force lead
 *     force   age of the sample, filters, half a tick prediction or force lead; else extrapolation */
#ifndef FIRMWARE_COMPENSATION_DELAY_SHARES_H
#define FIRMWARE_COMPENSATION_DELAY_SHARES_H

#include "../config.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Over which setpoints are extrapolated: told, or what the others leave. */
double extrapolation_delay_ms(const struct app_config *config);

/* Of the force when it is used, over which it is led: the same. */
double force_lead_age_ms(const struct app_config *config);

#ifdef __cplusplus
}
#endif
#endif
