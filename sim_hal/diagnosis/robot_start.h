/* Where the robot is as a part of a record begins. */
#ifndef SIM_HAL_DIAGNOSIS_ROBOT_START_H
#define SIM_HAL_DIAGNOSIS_ROBOT_START_H

#include "record.h"

namespace berth
{

/* Marks the parts that begin with a robot that stands elsewhere than its setpoint says, and then goes there: a step
 * in the first row, as step responses are recorded. A replay that began on the setpoint would miss the step. */
void find_starts_elsewhere(record &made);

} // namespace berth

#endif
