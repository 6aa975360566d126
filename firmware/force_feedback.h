/* How much of the measured force the manipulator feels: all of it, a share, or a share that rises from 0 while the
 * loop runs. For commissioning: a loop that is closed by degrees shows its trouble while it is still small. */
#ifndef FIRMWARE_FORCE_FEEDBACK_H
#define FIRMWARE_FORCE_FEEDBACK_H

#include "config.h"

#ifdef __cplusplus
extern "C" {
#endif

struct force_feedback {
    uint8_t is_whole; /* all of the force, at once: nothing to do */
    double gain;      /* in this tick: 0 to 1 */
    double gain_max;
    double gain_per_tick; /* 0: at once */
    int64_t ticks;        /* that the loop has been running */
};

void force_feedback_start(struct force_feedback *feedback, const struct app_config *config);

/* One tick, where it is not whole. The ramp begins anew whenever the loop begins to run. */
void force_feedback_step(struct force_feedback *feedback, int is_running);

/* The gain in the running tick with this number, from 1 on. A pure function. */
double force_feedback_gain(const struct app_config *config, int64_t running_tick);

#ifdef __cplusplus
}
#endif
#endif
