#include "verdict.h"

#include <algorithm>

namespace berth
{

namespace
{

constexpr std::size_t least_heights = 8;

/* What moves little more than this share of its first half in its second has come to rest; in between, a slow growth
 * may be hidden in what the release has left. */
constexpr double comes_to_rest = 0.2;

double range(std::vector<double>::const_iterator from, std::vector<double>::const_iterator to)
{
    const auto [low, high] = std::minmax_element(from, to);
    return *high - *low;
}

bool limits_acted_late(const run_result &result)
{
    return result.limited_until_sample > 3 * result.running_m.size() / 4;
}

double median_height(std::vector<oscillation_height>::const_iterator from,
                     std::vector<oscillation_height>::const_iterator to)
{
    std::vector<double> values;
    std::transform(from, to, std::back_inserter(values), [](const oscillation_height &h) { return h.value; });
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/* Limits bound the motion: does it fall nevertheless? */
std::optional<bool> judge_limited(const run_result &result, double period_s)
{
    constexpr double falls = 0.9;
    const std::vector<oscillation_height> heights = oscillation_heights(result.running_m, period_s);
    if (heights.size() < least_heights) {
        return {};
    }
    const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
    return median_height(middle, heights.end()) < falls * median_height(heights.begin(), middle);
}

/* It did not swing often enough to tell growth from decay: it would have with more time. */
bool is_too_short(const run_result &result, double period_s, double half_swing_s)
{
    const std::vector<oscillation_height> heights = oscillation_heights(result.running_m, period_s);
    const std::size_t count = heights.size();
    const double seen_s = count >= 2 ? heights[count - 1].time_s - heights[count - 2].time_s : 0.0;
    const double duration_s = static_cast<double>(result.running_m.size()) * period_s;
    return count < least_heights && duration_s < least_heights * std::max(half_swing_s, seen_s);
}

} // namespace

std::optional<bool> judge(const run_result &result, double period_s, double half_swing_s)
{
    if (result.running_m.empty()) {
        return {};
    }
    if (result.cause == STOP_NOT_FINITE) {
        return false;
    }
    if (result.growth && (result.growth->growth_per_s > 0.0 || !limits_acted_late(result))) {
        return result.growth->growth_per_s < 0.0;
    }
    if (limits_acted_late(result)) {
        return judge_limited(result, period_s);
    }
    if (result.cause != STOP_NONE && result.cause != STOP_REQUESTED) {
        return {};
    }
    if (result.is_ordered) {
        return {}; /* how far it went was ordered */
    }
    if (is_too_short(result, period_s, half_swing_s)) {
        return {};
    }
    const auto middle = result.running_m.begin() + static_cast<std::ptrdiff_t>(result.running_m.size() / 2);
    if (middle == result.running_m.begin()) {
        return true;
    }
    const double first = range(result.running_m.begin(), middle);
    const double second = range(middle, result.running_m.end());
    if (second > first) {
        return false;
    }
    return second <= comes_to_rest * first ? std::optional<bool>(true) : std::nullopt;
}

} // namespace berth
