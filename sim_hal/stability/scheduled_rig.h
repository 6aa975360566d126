/* The loops that a rig file schedules one after the other: a jump of the dead time (run.dead_time_jump_s), a dead
 * time or a stiffness that drifts. At each instant the loop is taken as if it stayed what it is then. */
#ifndef SIM_HAL_STABILITY_SCHEDULED_RIG_H
#define SIM_HAL_STABILITY_SCHEDULED_RIG_H

#include <string>
#include <vector>

#include "../../hal/rig/rig.h"

namespace berth
{

/* Whether the loop changes on schedule while it is closed: between release and grip on the one hand, and end,
 * letting go and stop of the run on the other. */
bool has_schedule(const rig &rig);

/* On the clock of the run, in order: when the loop is closed, each jump, and equal steps along a drift, fewer where
 * each would take long to judge. */
std::vector<double> instants_of_schedule(const rig &rig);

/* The rig as it is at an instant, with nothing scheduled. */
rig rig_at(const rig &original, double at_s);

/* Why the loop at an instant cannot be predicted; empty: it can. */
std::string reason_against(const rig &original, const rig &at);

} // namespace berth

#endif
