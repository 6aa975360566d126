/* The noise in a signal tells two measurements apart: each has its own, and a copy has the original's, be it turned
 * over, backwards, shifted, scaled, or written with fewer digits. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_NOISE_FINGERPRINT_H
#define SIM_HAL_DIAGNOSIS_RECORD_NOISE_FINGERPRINT_H

#include <cstddef>
#include <optional>
#include <vector>

#include "signal_news.h"

namespace berth
{

/* Row n of the other signal is row `begin` + n of the first one, or `begin` - n where it runs backwards. */
struct copy_found {
    std::size_t column;
    std::ptrdiff_t begin;
    bool is_backwards;
    double factor; /* of the first one; below zero: turned over */
};

/* Looks for the noise of the first signals, column by column, in the others, at every shift and in both directions.
 * A copy has it in every column whose noise can tell; a column that is the same but for rounding is one by itself.
 * The first ones are driven by those after them. */
std::optional<copy_found> find_copy(const std::vector<measured_signal> &first,
                                    const std::vector<measured_signal> &others);

} // namespace berth

#endif
