#include "advice.h"

#include <cmath>
#include <cstdio>

#include "../firmware/compensation/compensation.h"
#include "../hal/rig/beam.h"
#include "../hal/rig/rig_file.h"
#include "bounce_limits.h"
#include "effects/active.h"
#include "prediction.h"
#include "stability/loop_timeline.h"
#include "stability/spectrum.h"

namespace berth
{

namespace
{

/* As fine_scan, coarser and over a narrower range: an answer in a moment. */
constexpr scan advice_scan{0.02, 0.25, 10.0};

bool is_nearer(const near_limit &a, const near_limit &b)
{
    return std::abs(std::log(a.factor())) < std::abs(std::log(b.factor()));
}

std::optional<cure> try_prediction(const rig &of)
{
    rig with = of;
    with.firmware.prediction.enabled = 1;
    if (compensation_is_on(&of.firmware) || complete_and_check(with)) {
        return {};
    }
    const growth_prediction found = predict_growth(with);
    if (found.growth_per_s && *found.growth_per_s < 0.0 && !found.gains_by_bounces()) {
        return cure{"prediction", *found.growth_per_s};
    }
    return {};
}

/* Four digits, rounded into where it is stable. */
double on_the_safe_side(double value, bool stable_above)
{
    const double digit = std::pow(10.0, std::floor(std::log10(value)) - 3.0);
    return digit * (stable_above ? std::ceil(value / digit) : std::floor(value / digit));
}

} // namespace

std::optional<near_limit> nearest_limit(const std::vector<parameter_limits> &parameters, bool is_stable)
{
    std::optional<near_limit> nearest;
    for (const parameter_limits &parameter : parameters) {
        for (const stability_limit *const limit : {parameter.nearest_below(), parameter.nearest_above()}) {
            if (limit == nullptr || (limit->is_rough && !is_stable) || !(parameter.value > 0.0) ||
                !(limit->value > 0.0)) {
                continue; /* no factor leads there */
            }
            const near_limit candidate{std::string(parameter.key), parameter.value, *limit};
            if (!nearest || is_nearer(candidate, *nearest)) {
                nearest = candidate;
            }
        }
    }
    return nearest;
}

stability_advice advise(const rig &rig)
try {
    stability_advice found;
    const berth::rig linear = without_variation(in_contact(rig));
    if (rig.firmware.arm.kind != ARM_NONE || !left_out_when_small(linear).empty() || drifts_freely(linear)) {
        return found;
    }
    found.compensation = try_prediction(rig);
    if (compensation_is_on(&rig.firmware)) {
        return found;
    }
    const growth_prediction steady = predict_growth(linear);
    const bool bounces = rig.object.kind == object_kind::contact;
    if (!steady.growth_per_s || (*steady.growth_per_s < 0.0 && !bounces)) {
        return found; /* what changes from tick to tick makes it grow, and no parameter */
    }
    std::vector<parameter_limits> parameters;
    for (const std::string_view key : physical_parameters(linear)) {
        if (linear.object.kind == object_kind::beam && follows_from_beam(key)) {
            continue; /* no rig file may state it */
        }
        parameters.push_back(find_limits(linear, key, as_it_is, advice_scan));
        cut_by_bounces(parameters.back(), without_variation(rig));
    }
    found.change = nearest_limit(parameters, false);
    return found;
} catch (const input_error &) {
    return {};
}

std::string advice_text(const stability_advice &advice)
{
    char text[120];
    std::string all;
    if (advice.change) {
        const stability_limit &limit = advice.change->limit;
        std::snprintf(text, sizeof text, "%s %s %.6g", advice.change->key.c_str(),
                      limit.stable_above ? "above" : "below", on_the_safe_side(limit.value, limit.stable_above));
        all = text;
    }
    if (advice.compensation) {
        std::snprintf(text, sizeof text, "%s--with %s: %+.2g /s", all.empty() ? "" : ", or ",
                      advice.compensation->with.c_str(), advice.compensation->growth_per_s);
        all += text;
    }
    return all;
}

} // namespace berth
