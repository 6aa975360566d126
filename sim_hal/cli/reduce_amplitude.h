/* How far an arm's reduction to one degree of freedom holds by the size of the motion: `berth reduce --amplitude`.
 */
#ifndef SIM_HAL_CLI_REDUCE_AMPLITUDE_H
#define SIM_HAL_CLI_REDUCE_AMPLITUDE_H

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "../stability/reduction.h"

namespace berth
{

/* m; from one to the other by equal ratios. */
struct amplitude_range {
    double from_m;
    double to_m;
    int count;
};

/* "0.001:1:7". Throws input_error. */
amplitude_range amplitudes_of(const std::string &text);

struct amplitude_row {
    double amplitude_m;
    free_swing full;
};

struct amplitude_result {
    swing small; /* of the whole arm, linearised */
    swing reduced;
    std::vector<amplitude_row> rows;
    /* From where on it is more than 1 %. */
    struct limit {
        std::optional<double> from_m; /* nothing: nowhere as far as was looked */
        double looked_to_m = 0.0;     /* up to here there is something to compare with, row by row; 0: nowhere */
        bool is_determined = false;   /* from_m is known, or all the range was looked through */
    };
    struct limits {
        limit frequency;
        limit damping;
    };
    limits reduced_off; /* the reduced against the whole arm */
    limits size_alone;  /* the whole arm against its own small motions */
};

/* Throws input_error where no swing of the whole arm with the object is near the reduction's, and for a rig with
 * effects that the swing would not have. */
amplitude_result look_at_amplitudes(const arm_config &config, const reduction_choice &choice, const rig &rig,
                                    const reduction &found, const amplitude_range &range);

void print_amplitudes(const amplitude_result &result);
nlohmann::json as_json(const amplitude_result &result);

} // namespace berth

#endif
