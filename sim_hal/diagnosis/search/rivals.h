/* Causes of the robot that its reports alone cannot tell apart, weighed by reports and force together. */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_RIVALS_H
#define SIM_HAL_DIAGNOSIS_SEARCH_RIVALS_H

#include "robot_and_force.h"

namespace berth
{

/* Each rival is fitted by itself, to the reports and, with what they leave open, to the force. One that is clearly
 * worse in the sum of both is dropped, and one that leaves the force to other causes of its own; one that is clearly
 * better takes the place of what was named; with more parameters it must be more so. Otherwise their number does not
 * count: where neither shows more, the shorter one is none the likelier. */
void weigh_rivals_together(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                           const block_start &robot_start, const block_start &force_start, const rig &as_given);

} // namespace berth

#endif
