/* Whether a rig's own run starts at all, and gets through its first seconds: its beginning is run in virtual time.
 */
#ifndef SIM_HAL_START_TRIAL_H
#define SIM_HAL_START_TRIAL_H

#include <optional>
#include <string>

#include "../firmware/recorder.h"
#include "../hal/rig/rig.h"
#include "motion.h"
#include "prediction.h"

namespace berth
{

struct start_trial {
    bool has_run = false;
    std::string obstacles;        /* of one that never ran: what kept it from running */
    std::optional<run_stop> stop; /* by a fault that nobody ordered, before or while it ran */

    bool is_good() const { return has_run && !stop; }
};

/* The rig as it is, with its noise, up to `running_s` of running or to the end of its run. Throws input_error. */
start_trial try_start(const rig &rig, double running_s = 2.0);

/* Of a rig that no exponent can be computed of: whether the supervisor never comes to running, so that there is no
 * loop and no margin of it. */
bool never_runs(const rig &rig, const growth_prediction &prediction);

/* In one sentence; empty of a good one. */
std::string trial_words(const start_trial &trial);

/* What keeps the supervisor from leaving start, read off the conditions of a run's last tick: ": this, that". */
std::string obstacles_of(const rig &rig, const tick_record &last);

} // namespace berth

#endif
