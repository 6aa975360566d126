/* The noise of a measured signal from row to row, and what that of a motion that stands for the command makes of the
 * force that it drives. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_MOTION_NOISE_H
#define SIM_HAL_DIAGNOSIS_RECORD_MOTION_NOISE_H

#include "../replay/block_model.h"

namespace berth
{

/* Noise of a measured column from row to row, rms in its unit: of its sixth differences, which motion slower than a
 * tenth of the rate hardly has; no less than its steps leave open. Noise that hangs together is larger than that. */
double noise_from_row_to_row(const record &data, const std::vector<double> &column);

/* That of the robot's position. */
double motion_noise_m(const record &data);

/* rms, in N, of what such noise makes of the force through `rig`: found by replaying the motion with as much again.
 * 0 where setpoints drive the robot. */
double force_of_motion_noise_N(const record &data, const rig &rig, const sample_events &events);

} // namespace berth

#endif
