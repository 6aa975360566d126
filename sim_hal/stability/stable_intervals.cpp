#include "stable_intervals.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace berth
{

namespace
{

constexpr double narrowest = 1e-5; /* of its end: a narrower interval is one value */

bool is_one_value(const stable_interval &interval)
{
    return interval.to - interval.from <= narrowest * std::abs(interval.to);
}

} // namespace

std::vector<stable_interval> intervals_between(const std::vector<double> &grid, bool starts_stable,
                                               std::vector<double> ends)
{
    if (starts_stable) {
        ends.insert(ends.begin(), grid.front());
    }
    if (ends.size() % 2 == 1) {
        ends.push_back(grid.back());
    }
    std::vector<stable_interval> intervals;
    for (std::size_t i = 0; i < ends.size(); i += 2) {
        intervals.push_back({ends[i], ends[i + 1]});
    }
    return intervals;
}

std::vector<stable_interval> without_single_values(std::vector<stable_interval> all, double own)
{
    const auto goes = [own](const stable_interval &interval) {
        const double near = narrowest * std::abs(own);
        return is_one_value(interval) && (own < interval.from - near || own > interval.to + near);
    };
    all.erase(std::remove_if(all.begin(), all.end(), goes), all.end());
    return all;
}

std::vector<stable_interval> stable_beyond(const parameter_limits &parameter)
{
    std::vector<stable_interval> beyond;
    if (const stability_limit *const limit = parameter.nearest_above()) {
        std::copy_if(parameter.stable.begin(), parameter.stable.end(), std::back_inserter(beyond),
                     [&](const stable_interval &part) { return part.from > limit->value; });
    }
    return beyond;
}

bool is_open_beyond(const parameter_limits &parameter)
{
    return !parameter.stable.empty() && parameter.stable.back().to == parameter.to;
}

} // namespace berth
