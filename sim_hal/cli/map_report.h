/* What a map amounts to, as a CSV file, for a program and for a person. */
#ifndef SIM_HAL_CLI_MAP_REPORT_H
#define SIM_HAL_CLI_MAP_REPORT_H

#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "../stability/varying_map.h"
#include "map_request.h"

namespace berth
{

/* A request, and what makes the loop change from tick to tick, if anything does. */
struct map_job {
    map_request request; /* of the loop that does not change */
    std::optional<map_request> varying;
    wake_histogram histogram;
    std::int64_t ticks = 0;
};

/* At each point. */
struct map_values {
    map_result steady;
    std::vector<double> exponents; /* none if the loop does not change */
};
/* Counted over all points. */
struct map_summary {
    std::size_t possible = 0;
    std::size_t not_passive = 0;
    std::size_t invalid = 0;
    std::size_t stable = 0;
    std::size_t below_wall = 0;
    std::size_t stable_below_wall = 0;
    std::size_t stable_varying = 0;
    std::size_t stable_varying_below_wall = 0;
    double stable_intervals = 0.0; /* along x, the limit found between two points: finer than counting points */
    double stable_intervals_varying = 0.0;
    double least = std::numeric_limits<double>::infinity();
    double largest = 0.0;
};

/* Hands the lines of the CSV file to `write`, row by row; returns what they amount to. */
map_summary write_csv(const map_request &request, const map_values &map,
                      const std::function<void(std::string_view)> &write);

/* For a program. */
nlohmann::json as_json(const map_job &job, const map_summary &sums);

/* For a person; `json` from as_json(), with compute_s. */
void print_map_summary(const map_request &request, const map_summary &sums, const nlohmann::json &json);

} // namespace berth

#endif
