/* Sizes from which a search for an effect starts, for effects with one parameter. */
#ifndef SIM_HAL_EFFECTS_STARTS_H
#define SIM_HAL_EFFECTS_STARTS_H

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "effect.h"

namespace berth
{

inline std::vector<effect_values> sizes(std::initializer_list<double> values)
{
    std::vector<effect_values> all;
    all.reserve(values.size());
    for (const double value : values) {
        all.push_back({value});
    }
    return all;
}

inline std::vector<effect_values> sizes_of(double scale, std::initializer_list<double> shares)
{
    std::vector<effect_values> all;
    all.reserve(shares.size());
    for (const double share : shares) {
        all.push_back({share * scale});
    }
    return all;
}

/* Limits below the largest value of what they limit: close ones act seldom, and each matters by itself. */
inline std::vector<effect_values> limits_below(double largest)
{
    return sizes_of(largest, {0.993, 0.985, 0.97, 0.95, 0.925, 0.89, 0.85, 0.8, 0.74, 0.67, 0.6, 0.5, 0.4, 0.3, 0.2,
                              0.1, 0.05, 0.025, 0.012});
}

/* `count` sizes from share to share of the scale, each larger than the one before by the same factor. */
inline std::vector<effect_values> grid_of(double scale, double from, double to, int count)
{
    std::vector<effect_values> all;
    all.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; i++) {
        all.push_back({scale * from * std::pow(to / from, static_cast<double>(i) / (count - 1))});
    }
    return all;
}

inline std::vector<effect_values> both_signs(std::initializer_list<double> values)
{
    std::vector<effect_values> all;
    for (const double value : values) {
        all.push_back({value});
        all.push_back({-value});
    }
    return all;
}

/* A delay of a few periods more or less: under steps each leads no farther than its neighbours. */
inline std::vector<effect_values> shifted(double delay_ms, double period_ms)
{
    std::vector<effect_values> all;
    all.reserve(8);
    for (const double periods : {-3.0, -1.0, -0.5, 0.5, 1.0, 3.0, 6.0, 12.0}) {
        all.push_back({std::max(0.1 * period_ms, delay_ms + periods * period_ms)});
    }
    return all;
}

} // namespace berth

#endif
