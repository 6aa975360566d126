/* The CSV file of a map, and what its points amount to. */
#ifndef SIM_HAL_CLI_MAP_CSV_H
#define SIM_HAL_CLI_MAP_CSV_H

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>
#include <string_view>
#include <vector>

#include "../compensation/measured_map.h"
#include "../stability/stability_map.h"

namespace berth
{

/* At each point. */
struct map_values {
    map_result steady;
    std::optional<map_result> lower_end;
    std::optional<map_result> reduced;    /* with an arm: of the manipulator that it is reduced to */
    std::vector<double> exponents;        /* none if the loop does not change */
    std::vector<measured_point> measured; /* where each point is run; `steady` has what |z| would be */
    std::vector<double> restitution; /* of a tool in contact; NaN: the tool never comes off again, or no such rig */
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

/* A run whose motion is nearer than this to the one without dead time, as a share of its swing, is true to it. */
constexpr double true_error = 0.05;

/* Of the points that were run. */
struct measured_sums {
    std::size_t lasting = 0; /* neither decay nor grow */
    std::size_t lasting_below_wall = 0;
    std::size_t faulted = 0; /* were stopped by a fault before they grew */
    std::size_t faulted_below_wall = 0;
    std::size_t faithful = 0; /* decay, and are true to the motion without dead time */
    std::size_t faithful_below_wall = 0;

    void add(const measured_point &point, bool is_below_wall)
    {
        const bool lasts = point.fate == fate::lasts;
        const bool is_true = point.fate == fate::decays && point.error < true_error;
        lasting += lasts;
        lasting_below_wall += lasts && is_below_wall;
        faulted += point.is_faulted;
        faulted_below_wall += point.is_faulted && is_below_wall;
        faithful += is_true;
        faithful_below_wall += is_true && is_below_wall;
    }
};

/* Of the points of a map with an arm: where its reduction tells otherwise. */
struct misled_sums {
    std::size_t compared = 0;
    std::size_t falsely_stable = 0;
    std::size_t falsely_unstable = 0;

    void add(double whole, double reduced)
    {
        compared++;
        falsely_stable += reduced < 1.0 && whole >= 1.0;
        falsely_unstable += reduced >= 1.0 && whole < 1.0;
    }
};

/* Of the bounces of a map. */
struct bounce_sums {
    std::size_t played = 0;
    std::size_t gaining = 0;
    double least = std::numeric_limits<double>::infinity();
    double largest = -std::numeric_limits<double>::infinity();

    void add(double restitution)
    {
        played++;
        gaining += restitution > 1.0;
        least = std::min(least, restitution);
        largest = std::max(largest, restitution);
    }
};

struct map_summary {
    bounce_sums bounces;
    measured_sums measured;
    misled_sums misled;
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

} // namespace berth

#endif
