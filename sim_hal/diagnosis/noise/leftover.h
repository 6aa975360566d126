/* What is left of an error that depends on the state or on time, whatever its name: a regression on many plain
 * features, judged on parts that it was not fitted to. */
#ifndef SIM_HAL_DIAGNOSIS_NOISE_LEFTOVER_H
#define SIM_HAL_DIAGNOSIS_NOISE_LEFTOVER_H

#include <vector>

#include "motion_features.h"

namespace berth
{

struct leftover {
    double explained = 0.0; /* sum of squares of the white error that the features explain on unseen parts */
    double rows = 0.0;
    double share_of_rms = 0.0; /* explained share of the white sum of squares */
    error_class strongest = error_class::linear;
};

/* An error of the model less what the features explain of it, in the block's unit, one a row. */
std::vector<double> unexplained_by(const block_model &model, const noise_model &noise,
                                   const std::vector<feature> &features, const std::vector<double> &error);

/* Of an error of the model; `rig`: of the error, and the model's last one. */
leftover find_leftover(const block_model &model, const noise_model &noise, const rig &rig,
                       const std::vector<double> &error);

} // namespace berth

#endif
