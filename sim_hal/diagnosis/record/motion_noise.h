/* The noise of a measured motion that stands for the command: what it makes of the force that it drives. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_MOTION_NOISE_H
#define SIM_HAL_DIAGNOSIS_RECORD_MOTION_NOISE_H

#include "../replay/block_model.h"

namespace berth
{

/* Noise of the robot's position from row to row, rms in m: of its sixth differences, which motion slower than a
 * tenth of the rate hardly has; no less than its steps leave open. Noise that hangs together is larger than that. */
double motion_noise_m(const record &data);

/* rms, in N, of what such noise makes of the force through `rig`: found by replaying the motion with as much again.
 * 0 where setpoints drive the robot. */
double force_of_motion_noise_N(const record &data, const rig &rig, const sample_events &events);

} // namespace berth

#endif
