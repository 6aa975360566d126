/* What is left of an error that depends on the state or on time, whatever its name: a regression on many plain
 * features, judged on parts that it was not fitted to. */
#ifndef SIM_HAL_DIAGNOSIS_LEFTOVER_H
#define SIM_HAL_DIAGNOSIS_LEFTOVER_H

#include <string>
#include <vector>

#include "block_model.h"

namespace berth
{

/* How an error depends on the motion. */
enum class error_class { linear, odd, even, drift, hysteresis, count };

constexpr std::string_view error_class_names[] = {"linear in the motion", "odd in the motion", "even in the motion",
                                                  "drift over time", "hysteresis or direction of motion"};

struct leftover {
    double explained = 0.0; /* sum of squares of the white error that the features explain on unseen parts */
    double rows = 0.0;
    double share_of_rms = 0.0; /* explained share of the white sum of squares */
    error_class strongest = error_class::linear;
    std::vector<double> unexplained; /* error less what the features explain, in the block's unit, one a row */
};

/* `error`: of the model under test, `rig` its rig. */
leftover find_leftover(block_model &model, const noise_model &noise, const rig &rig,
                       const std::vector<double> &error);

} // namespace berth

#endif
