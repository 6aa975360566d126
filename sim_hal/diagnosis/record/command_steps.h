/* A command column that was written with too few digits: the robot was sent something finer. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_COMMAND_STEPS_H
#define SIM_HAL_DIAGNOSIS_RECORD_COMMAND_STEPS_H

#include "../replay/block_model.h"

namespace berth
{

/* The step in which the command's column moves, in m; 0 where it is no coarser than the wire's, or where the command
 * jumps from level to level or goes at one rate, which may be exact. */
double command_step_m(const record &data, const rig &rig);

/* rms, in the block's unit, of what such steps leave open of its output: found by replaying the command with other
 * roundings. 0 where the command has no coarse steps or is the output itself. */
double rms_of_command_steps(block block, const record &data, const rig &rig, const sample_events &events);

/* The steps themselves were what the robot was sent, as by a controller that counts in them: in their place a smooth
 * command, nowhere off them by more than half of one, makes the block's error twice as large. */
bool were_steps_sent(block block, const record &data, const rig &rig, const sample_events &events);

/* An error that the steps of the input, with the noise, leave open as it is: what explains it explains rounding. */
bool is_of_input_steps(double error_rms, double steps_rms, double noise_rms);

} // namespace berth

#endif
