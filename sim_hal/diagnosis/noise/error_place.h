/* Where the error lives that nothing explains: in which band of frequencies, in which state of the motion. */
#ifndef SIM_HAL_DIAGNOSIS_NOISE_ERROR_PLACE_H
#define SIM_HAL_DIAGNOSIS_NOISE_ERROR_PLACE_H

#include <optional>

#include "../search/block_diagnosis.h"

namespace berth
{

struct frequency_band {
    double low_Hz;
    double high_Hz;
};

struct error_place {
    std::optional<frequency_band> band; /* holds the middle 80 % of the power above the floor; none: there is none */
    std::string_view state;             /* of the quarter of the rows that holds most of the squared error */
    double share = 0.0;                 /* that it holds */
};

/* Of the extended rig's error, in the rows in use as if they followed each other. */
error_place find_error_place(const block_diagnosis &block, const record &data);

} // namespace berth

#endif
