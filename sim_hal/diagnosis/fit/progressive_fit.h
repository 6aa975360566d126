/* Effects whose errors jump with their size: fitted over a horizon that grows. */
#ifndef SIM_HAL_DIAGNOSIS_FIT_PROGRESSIVE_FIT_H
#define SIM_HAL_DIAGNOSIS_FIT_PROGRESSIVE_FIT_H

#include <optional>

#include "fit.h"

namespace berth
{

/* Over a whole record the error jumps with every parameter: one event at another moment, and another history
 * follows. Up to the first event it does not, nor up to the second from values that suit the first. The base model
 * is fitted to the beginning of the record; where it no longer suffices, the effect comes in, with the best of the
 * sizes of its `starts`; each longer horizon begins where the one before has ended. `parameters`: of the base model
 * and of what was found before. The result has the effect's first parameter besides. */
fit_result fit_progressively(block_model &model, const noise_model &noise, const effect &effect, const rig &base,
                             const std::vector<free_parameter> &parameters, const std::vector<rig> &starts,
                             int replays_max);

/* A size of an effect that switches a thousand times must be right to a thousandth before the error shows it: the
 * best few between the `starts` over the first movement, and of sizes about them, ever nearer as the horizon grows.
 * The base model's parameters follow the best one. Nothing where the first movement knows of none. */
std::optional<rig> size_on_growing_horizon(block_model &model, const noise_model &noise, const effect &effect,
                                           const rig &base, const std::vector<free_parameter> &parameters,
                                           const std::vector<rig> &starts, int replays_max);

} // namespace berth

#endif
