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
    std::optional<free_swing> full;
};

struct amplitude_result {
    swing small; /* of the whole arm, linearised */
    swing reduced;
    std::vector<amplitude_row> rows;
    /* From where on it is more than 1 %; nothing: nowhere in the range. */
    struct limits {
        std::optional<double> frequency_m;
        std::optional<double> damping_m;
    };
    limits reduced_off; /* the reduced against the whole arm */
    limits size_alone;  /* the whole arm against its own small motions */
};

/* Throws input_error for an arm that does not swing with the object. */
amplitude_result look_at_amplitudes(const arm_config &config, const reduction_choice &choice,
                                    const object_rig &object, const reduction &found, const amplitude_range &range);

void print_amplitudes(const amplitude_result &result);
nlohmann::json as_json(const amplitude_result &result);

} // namespace berth

#endif
