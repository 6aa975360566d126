/* Dead time from command to motion, measured through the seam: a step of the setpoint out, feedback in. Knows
 * nothing of what is behind hal.h. */
#ifndef SIM_HAL_HIL_DEADTIME_H
#define SIM_HAL_HIL_DEADTIME_H

#include <vector>

#include "../../firmware/config.h"
#include "../../hal/hal.h"

namespace berth
{

struct deadtime_measurement {
    double command_to_motion_s; /* step of the command to passage of the robot, lag of its transfer behaviour
                                   included */
    double first_motion_s;      /* step of the command to the first tick at which the robot has moved */
    std::vector<double> step;   /* robot position at the ticks after the command, 0 to 1 */
};

/* Holds the robot, steps the setpoint by `step_m` and watches for `watch_s`. With straight lines between setpoints
 * the passage is exact for any real dead time (the area between command and motion, which a line within one tick
 * does not hide); with "hold" it is known to one tick. Returns HAL_OK,
 * HAL_END if the feedback does not come, or what the HAL said. */
hal_status measure_deadtime(struct hal *hal, const app_config &config, double step_m, double watch_s,
                            deadtime_measurement &result);

/* The same for a CiA 402 drive, with the firmware's channel as its master. What it reports is of the SYNC before. */
hal_status measure_drive_deadtime(struct hal *hal, const app_config &config, double step_m, double watch_s,
                                  deadtime_measurement &result);

} // namespace berth

#endif
