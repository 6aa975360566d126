/* What helps most, and the nearest limit, as told by `berth limits`. */
#ifndef SIM_HAL_CLI_GAINS_REPORT_H
#define SIM_HAL_CLI_GAINS_REPORT_H

#include <nlohmann/json.hpp>
#include <vector>

#include "../stability/gains.h"

namespace berth
{

struct gain_ranking {
    double share;
    std::optional<loop_quality> now;
    std::vector<parameter_gain> gains;
};

/* "rank": by falling decay; "rank_by_margin": of a stable loop, by falling modulus margin. */
nlohmann::json as_json(const gain_ranking &ranking);

void print_gains(const gain_ranking &ranking);

/* The limit that the smallest factor of its parameter leads to: the way out of stability, or into it. Null, or
 * nothing, where there is none. */
nlohmann::json nearest_limit_json(const std::vector<parameter_limits> &parameters, bool is_stable);
void print_nearest_limit(const std::vector<parameter_limits> &parameters, bool is_stable);

} // namespace berth

#endif
