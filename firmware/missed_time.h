/* How much time the loop may miss: a budget in time, which refills. A few missed ticks at once use it up as far as
 * they go, and so do single ones that come faster than it refills. */
#ifndef FIRMWARE_MISSED_TIME_H
#define FIRMWARE_MISSED_TIME_H

#include "config.h"

#ifdef __cplusplus
extern "C" {
#endif

struct missed_time {
    int64_t period_ns;
    int64_t budget_ns;
    int64_t refill_ns_per_tick;
    int64_t used_ns;
};

/* The whole budget is there. */
void missed_time_start(struct missed_time *missed, const struct app_config *config);

/* One tick, before which `missed_ticks` were missed. */
void missed_time_step(struct missed_time *missed, uint32_t missed_ticks);

/* More was missed than the budget had. */
int missed_time_is_over(const struct missed_time *missed);

#ifdef __cplusplus
}
#endif
#endif
