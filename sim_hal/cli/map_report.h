/* What a map amounts to, as a CSV file, for a program and for a person. */
#ifndef SIM_HAL_CLI_MAP_REPORT_H
#define SIM_HAL_CLI_MAP_REPORT_H

#include <algorithm>
#include <functional>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "../stability/varying_map.h"
#include "map_request.h"
#include "robot_choice.h"

namespace berth
{

/* What is to be computed. All but `varying` are of the loop that does not change from tick to tick. */
struct map_job {
    chosen_rig chosen;
    map_request request;
    std::optional<map_request> lower_end; /* of the dead times that the robot preset reports, if they are a range */
    std::optional<map_request> varying;   /* if the loop changes: at the upper end */
    wake_histogram histogram;
    std::int64_t ticks = 0;
};

/* At each point. */
struct map_values {
    map_result steady;
    std::optional<map_result> lower_end;
    std::vector<double> exponents; /* none if the loop does not change */
};

/* Counted over all points of one map. */
struct map_sums {
    std::size_t possible = 0;
    std::size_t below_wall = 0;
    std::size_t stable = 0;
    std::size_t stable_below_wall = 0;
    double least = std::numeric_limits<double>::infinity();
    double largest = -std::numeric_limits<double>::infinity();

    void add(double value, bool is_stable, bool is_below_wall)
    {
        possible++;
        below_wall += is_below_wall;
        stable += is_stable;
        stable_below_wall += is_stable && is_below_wall;
        least = std::min(least, value);
        largest = std::max(largest, value);
    }
};

struct map_summary {
    map_sums steady;    /* of |z| */
    map_sums lower_end; /* of |z| */
    map_sums varying;   /* of exponents */
    std::size_t not_passive = 0;
    std::size_t invalid = 0;
    double stable_intervals = 0.0; /* along x, the limit found between two points: finer than counting points */
    double stable_intervals_varying = 0.0;
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
