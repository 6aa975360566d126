#include "as_given.h"

#include <algorithm>
#include <cmath>

namespace berth
{

namespace
{

bool is_as_given(const cause &found, const rig &given)
{
    if (!found.effect->is_rough && !found.effect->is_of_single_samples) {
        return false;
    }
    return std::all_of(found.parameters.begin(), found.parameters.end(), [&](const parameter_estimate &one) {
        const std::optional<double> tolerance = given.tolerance_of(one.key);
        const double known = value_of(given, one.key);
        const double chance = found.effect->is_of_single_samples && std::isfinite(one.ci95) ? one.ci95 : 0.0;
        return tolerance && std::abs(one.value - known) <= std::max(*tolerance * std::abs(known), chance);
    });
}

} // namespace

void drop_causes_as_given(block_diagnosis &result, const rig &given)
{
    const auto first = std::remove_if(result.causes.begin(), result.causes.end(),
                                      [&](const cause &found) { return is_as_given(found, given); });
    if (first == result.causes.end()) {
        return;
    }
    result.causes.erase(first, result.causes.end());
    if (result.causes.empty() && result.verdict == verdict::named) {
        result.verdict = verdict::nothing_detectable;
    } else if (result.causes.empty() && result.verdict == verdict::partly_explained) {
        result.verdict = verdict::unknown;
    }
}

} // namespace berth
