/* How much better one rig predicts than another on rows that no fit has seen. */
#ifndef SIM_HAL_DIAGNOSIS_GAIN_H
#define SIM_HAL_DIAGNOSIS_GAIN_H

#include <vector>

#include "block_model.h"

namespace berth
{

/* Share by which the white sum of squares falls, with its 95 % interval. */
struct gain {
    double value;
    double low;
    double high;
};

/* White sums of squares of two rigs over blocks of half a second, which keep what hangs together together. */
struct paired_sums {
    std::vector<double> before;
    std::vector<double> after;
};

/* Adds the rows with this use. */
void add_sums(paired_sums &sums, block_model &model, const noise_model &noise, const rig &before, const rig &after,
              row_use use);

/* The interval comes from resampling the blocks. */
gain gain_from(const paired_sums &sums);

} // namespace berth

#endif
