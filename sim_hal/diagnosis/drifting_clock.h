/* How late a robot is over time, and the clock that would make it so. */
#ifndef SIM_HAL_DIAGNOSIS_DRIFTING_CLOCK_H
#define SIM_HAL_DIAGNOSIS_DRIFTING_CLOCK_H

#include <vector>

#include "../effects/effect.h"
#include "block_model.h"
#include "fit.h"

namespace berth
{

/* The clocks whose sawtooth of dead time fits best to the lateness in `error` (measured less simulated) along the
 * motion `position_m`: at most `count`, none where the robot hardly moves. */
std::vector<clock_guess> drifting_clocks(const std::vector<double> &error, const std::vector<double> &position_m,
                                         double period_s, int count);

/* Phase and drift of a free clock such that each of its slips, a setpoint taken twice or none, falls into the tick
 * in which a stiff contact shows it: the robot's own reports leave some ticks open. */
void match_slips(block_model &force, rig &rig);

/* Half widths of a free clock's phase and drift: how far they may be off while the slips stay in their ticks, and how
 * far the slips may. The slopes of a fit know of neither: an error jumps where a slip does. */
void widen_clock_intervals(block_model &model, const noise_model &noise, fit_result &fitted);

/* The model's uses, without the rows in which a slip in another tick would show. */
std::vector<row_use> uses_beside_slips(const block_model &model, const rig &rig);

} // namespace berth

#endif
