/* What becomes of a loop that a rig file schedules to change while it runs, see stability/scheduled_rig.h. */
#ifndef SIM_HAL_SCHEDULE_H
#define SIM_HAL_SCHEDULE_H

#include <string>
#include <vector>

#include "../hal/rig/rig.h"
#include "prediction.h"
#include "stability/scheduled_rig.h"

namespace berth
{

struct scheduled_loop {
    double from_s;  /* on the clock of the run */
    berth::rig rig; /* as it is then, with nothing scheduled */
    growth_prediction prediction;
};

/* The loops of the schedule, in order of time: at its start, from each jump on, and in equal steps along a drift.
 * With the instants, to 1 % of the run, at which a drift makes the loop stable or unstable. */
std::vector<scheduled_loop> loops_of_schedule(const rig &rig, const growth_predictor &predict);

/* The loop that decides: the one that grows most; else one whose growth is not known; else the one that decays
 * least. Its prediction holds the schedule. Of a rig without a schedule, the rig itself. */
scheduled_loop worst_of_schedule(const rig &rig, const growth_predictor &predict);

/* "stable before 5 s (-0.38 /s), unstable from then on"; empty: nothing is scheduled. */
std::string schedule_words(const growth_prediction &prediction);

} // namespace berth

#endif
