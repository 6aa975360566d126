#include "bounce_limits.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "bounce.h"

namespace berth
{

namespace
{

constexpr double step = 1.25;
constexpr double near_enough = 1e-4;
constexpr double lowest_share = 1e-3; /* of the upper end, where an interval begins at 0 */
constexpr double next_to_zero = 1e-6; /* of the first value above 0: a limit nearer to 0 is one at 0 */

struct bounces_along {
    const rig &original;
    const rig_key &key;

    std::optional<played_bounce> at(double value) const
    {
        const auto changed = with_value(original, key, value);
        return changed ? play_bounce(*changed) : std::nullopt;
    }
    std::optional<bool> gains(double value) const
    {
        const auto bounce = at(value);
        return bounce ? std::optional<bool>(bounce->energy_share() > 0.0) : std::nullopt;
    }

    /* A value without a bounce is on the side of the one before it, at the start on that of the next one. */
    std::vector<bool> gain_along(const std::vector<double> &grid) const
    {
        std::vector<std::optional<bool>> seen;
        std::transform(grid.begin(), grid.end(), std::back_inserter(seen),
                       [this](double value) { return gains(value); });
        const auto first = std::find_if(seen.begin(), seen.end(), [](const auto &one) { return one.has_value(); });
        bool before = first != seen.end() && **first;
        std::vector<bool> found;
        for (const std::optional<bool> &one : seen) {
            before = one.value_or(before);
            found.push_back(before);
        }
        return found;
    }
};

/* From one end to the other, with the rig's own value, which has to come out as it is by itself. */
std::vector<double> grid_of(const stable_interval &interval, double own)
{
    std::vector<double> grid{interval.from};
    double value = std::max(interval.from, lowest_share * interval.to) * step;
    while (value < interval.to) {
        grid.push_back(value);
        value *= step;
    }
    grid.push_back(interval.to);
    if (own > interval.from && own < interval.to) {
        grid.insert(std::upper_bound(grid.begin(), grid.end(), own), own);
    }
    return grid;
}

/* The last value that loses before, or behind, one that gains; not the rig's own, which has to lie on one side. */
stability_limit limit_between(const bounces_along &bounces, double own, double loses, double gains)
{
    const double least = gains == 0.0 || loses == 0.0 ? next_to_zero * std::abs(gains - loses) : 0.0;
    while (std::abs(gains - loses) > std::max(least, near_enough * std::max(std::abs(gains), std::abs(loses)))) {
        const double middle = 0.5 * (gains + loses);
        (bounces.gains(middle).value_or(false) ? gains : loses) = middle;
    }
    const double value = loses == own ? 0.5 * (loses + gains) : loses;
    stability_limit limit{value, loses > gains, "", {}, "a bounce gains energy"};
    if (const auto bounce = bounces.at(gains)) {
        limit.mode.frequency_Hz = bounce->contact_s > 0.0 ? 0.5 / bounce->contact_s : 0.0;
    }
    return limit;
}

/* The parts of an interval in which bounces lose; `found` gets the ends that bounces make. */
std::vector<stable_interval> losing_parts(const bounces_along &bounces, const stable_interval &interval, double own,
                                          std::vector<stability_limit> &found)
{
    const std::vector<double> grid = grid_of(interval, own);
    std::vector<stable_interval> parts;
    const std::vector<bool> gains = bounces.gain_along(grid);
    double from = grid.front();
    for (std::size_t i = 1; i < grid.size(); i++) {
        if (gains[i] != gains[i - 1]) {
            found.push_back(gains[i] ? limit_between(bounces, own, grid[i - 1], grid[i])
                                     : limit_between(bounces, own, grid[i], grid[i - 1]));
            if (gains[i]) {
                parts.push_back({from, found.back().value});
            }
            from = found.back().value;
        }
    }
    if (!gains.back()) {
        parts.push_back({from, grid.back()});
    }
    return parts;
}

} // namespace

void cut_by_bounces(parameter_limits &limits, const rig &rig)
{
    if (rig.object.kind != object_kind::contact || rig.firmware.arm.kind != ARM_NONE) {
        return;
    }
    const bounces_along bounces{rig, *find_key(limits.key)};
    std::vector<stability_limit> found;
    std::vector<stable_interval> parts;
    for (const stable_interval &interval : limits.stable) {
        const auto losing = losing_parts(bounces, interval, limits.value, found);
        parts.insert(parts.end(), losing.begin(), losing.end());
    }
    for (const stability_limit &limit : limits.limits) {
        const bool stays = std::any_of(parts.begin(), parts.end(), [&](const stable_interval &part) {
            return (limit.stable_above ? part.from : part.to) == limit.value;
        });
        if (stays) {
            found.push_back(limit);
        }
    }
    std::sort(found.begin(), found.end(),
              [](const stability_limit &a, const stability_limit &b) { return a.value < b.value; });
    limits.limits = std::move(found);
    limits.stable = std::move(parts);
}

} // namespace berth
