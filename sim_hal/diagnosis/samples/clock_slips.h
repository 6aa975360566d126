/* A robot's free clock that is known about: its slips, a setpoint taken twice or none, tell drift and phase. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_CLOCK_SLIPS_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_CLOCK_SLIPS_H

#include <vector>

#include "../fit/fit.h"
#include "../replay/block_model.h"

namespace berth
{

/* Phase and drift of a free clock such that each of its slips, a setpoint taken twice or none, falls into the tick
 * in which a stiff contact shows it: the robot's own reports leave some ticks open. */
void match_slips(block_model &force, fit_result &fitted);

/* A free clock that fits better, found by trying: slopes lead nowhere where slips jump from tick to tick. */
void polish_clock(block_model &model, const noise_model &noise, fit_result &fitted);

/* A phase of a whole period more is the same clock: the one of the first period. */
void wrap_clock_phase(rig &rig, double period_s);

/* Half widths of a free clock's phase and drift: how far they may be off while the slips stay in their ticks, and
 * how far the slips may. The slopes of a fit know of neither: an error jumps where a slip does. */
void widen_clock_intervals(block_model &model, const noise_model &noise, fit_result &fitted);

/* The model's uses, without the rows in which a slip in another tick would show. */
std::vector<row_use> uses_beside_slips(const block_model &model, const rig &rig);

} // namespace berth

#endif
