/* How late a robot is over time, and the clock that would make it so. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_DRIFTING_CLOCK_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_DRIFTING_CLOCK_H

#include <vector>

#include "../../effects/effect.h"

namespace berth
{

/* The clocks whose sawtooth of dead time fits best to the lateness in `error` (measured less simulated) along the
 * motion `position_m`: at most `count`, none where the robot hardly moves. */
std::vector<clock_guess> drifting_clocks(const std::vector<double> &error, const std::vector<double> &position_m,
                                         double period_s, int count);

} // namespace berth

#endif
