/* A record without setpoints: where the robot was seen is where it was, and that drives the force. The way between
 * the rows is a cubic spline through them. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_MEASURED_MOTION_H
#define SIM_HAL_DIAGNOSIS_RECORD_MEASURED_MOTION_H

#include "../replay/replay.h"

namespace berth
{

/* Where `record` has `robot_position_m` and `force_N`, and no command: takes the one for the other, and says so in
 * its notes. */
void drive_by_measured_motion(record &record);

/* The motion of such a record. A tick has at least `steps_min` steps. */
void replay_measured_motion(const rig &rig, const record &record, int steps_min, robot_motion &motion);

} // namespace berth

#endif
