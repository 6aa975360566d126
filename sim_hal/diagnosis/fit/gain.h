/* How much better one rig predicts than another on rows that no fit has seen. */
#ifndef SIM_HAL_DIAGNOSIS_FIT_GAIN_H
#define SIM_HAL_DIAGNOSIS_FIT_GAIN_H

#include <vector>

#include "../replay/block_model.h"

namespace berth
{

/* Share by which the white sum of squares falls, with its 95 % interval. */
struct gain {
    double value;
    double low;
    double high;
    double of_explainable; /* the same share of what is above the floor */
};

/* White sums of squares of two rigs over tenths of a second. */
struct paired_sums {
    std::vector<double> before;
    std::vector<double> after;
    double rows = 0.0; /* what the noise alone would sum up to */
};

/* Adds the rows with this use. */
void add_sums(paired_sums &sums, block_model &model, const noise_model &noise, const rig &before, const rig &after,
              row_use use);

/* The interval comes from resampling blocks of half a second, which keep what hangs together together. */
gain gain_from(const paired_sums &parts);

constexpr double few_blocks = 8.0;

/* How many blocks of half a second tell the two rigs apart: the participation ratio of the differences. */
double blocks_that_differ(const paired_sums &parts);

} // namespace berth

#endif
