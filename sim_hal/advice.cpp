#include "advice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "../firmware/compensation/compensation.h"
#include "../hal/rig/beam.h"
#include "../hal/rig/rig_file.h"
#include "bounce_limits.h"
#include "effects/active.h"
#include "flight_limits.h"
#include "prediction.h"
#include "schedule.h"
#include "stability/loop_timeline.h"
#include "stability/lyapunov.h"
#include "stability/physical_parameter.h"
#include "stability/spectrum.h"

namespace berth
{

namespace
{

/* As fine_scan, coarser and over a narrower range: an answer in a moment. */
constexpr scan advice_scan{0.02, 0.25, 10.0};
constexpr scan wide_advice_scan{0.05, 0.5, 1e3};

bool is_nearer(const near_limit &a, const near_limit &b)
{
    return std::abs(std::log(a.factor())) < std::abs(std::log(b.factor()));
}

/* Those that exist; of a loop that is to be cured without those that no advice names. */
std::vector<const stability_limit *> limits_beside(const parameter_limits &parameter, bool is_stable)
{
    std::vector<const stability_limit *> limits;
    if (const stability_limit *const below = parameter.nearest_below()) {
        limits.push_back(below);
    }
    const stability_limit *const above = parameter.nearest_above();
    if (above != nullptr && (is_stable || may_be_raised(parameter.key))) {
        limits.push_back(above);
    }
    return limits;
}

struct known_compensation {
    const char *option;
    std::vector<std::pair<const char *, const char *>> settings;
};

std::vector<known_compensation> compensations_for(const rig &rig)
{
    constexpr std::pair<const char *, const char *> no_extrapolation{"extrapolation.order", "0"};
    constexpr std::pair<const char *, const char *> no_lead{"force_lead.enabled", "false"};
    constexpr std::pair<const char *, const char *> no_inverse{"adaptive_inverse.enabled", "false"};
    constexpr std::pair<const char *, const char *> prediction{"prediction.enabled", "true"};
    if (rig.firmware.extrapolation.order > 0) {
        return {{"--set extrapolation.order=0", {no_extrapolation}},
                {"--set extrapolation.order=0 --with prediction", {no_extrapolation, prediction}}};
    }
    if (rig.firmware.force_lead.enabled) {
        return {{"--set force_lead.enabled=false --with prediction", {no_lead, prediction}},
                {"--set force_lead.enabled=false", {no_lead}}};
    }
    if (rig.firmware.adaptive_inverse.enabled) {
        return {{"--set adaptive_inverse.enabled=false", {no_inverse}},
                {"--set adaptive_inverse.enabled=false --with prediction", {no_inverse, prediction}}};
    }
    if (compensation_is_on(&rig.firmware)) {
        return {};
    }
    return {{"--with prediction", {prediction}},
            {"--with force-lead", {{"force_lead.enabled", "true"}}},
            {"--with extrapolation-1", {{"extrapolation.order", "1"}}}};
}

/* A swing takes longer than this to halve: a cure in name. */
constexpr double weak_s = 60.0;

bool is_weak(double growth_per_s)
{
    return -growth_per_s * weak_s < std::log(2.0);
}

/* The loop has an equation, which is the same in every tick: its limits are known by parameter. */
bool has_limits(const rig &rig)
{
    return rig.firmware.arm.kind == ARM_NONE && !compensation_is_on(&rig.firmware) && !is_time_varying(rig) &&
           !has_schedule(rig) && effects_of_size(rig).empty() && !drifts_freely(in_contact(rig));
}

/* A loop this long would take minutes. */
bool is_too_long(const rig &rig)
{
    return has_limits(rig) && make_loop_equation(in_contact(rig)).degree() > predicted_degree_max;
}

/* Far from the rig's own values limits of bounces would take long: there the cure itself is tried with them. */
std::optional<parameter_cure> change_by_limits(const rig &rig, const growth_predictor &predict, const scan &how,
                                               bool is_near)
{
    const berth::rig linear = in_contact(rig);
    std::vector<near_limit> candidates;
    for (const std::string_view key : physical_parameters(linear)) {
        if (linear.object.kind == object_kind::beam && follows_from_beam(key)) {
            continue; /* no rig file may state it */
        }
        if (!is_near && key.find("low_pass") != key.npos) {
            continue; /* far from its own value it would keep the force from the loop */
        }
        parameter_limits parameter = find_limits(linear, key, as_it_is, how);
        cut_by_flight(parameter, rig, how);
        if (is_near) {
            cut_by_bounces(parameter, rig);
        }
        for (const stability_limit *const limit : limits_beside(parameter, false)) {
            if (!limit->is_rough && limit->value > 0.0) {
                candidates.push_back({std::string(key), parameter.value, parameter.centre, *limit});
            }
        }
    }
    std::sort(candidates.begin(), candidates.end(), is_nearer);
    for (const near_limit &candidate : candidates) {
        if (auto found = change_to(rig, candidate, predict)) {
            return found;
        }
    }
    return {};
}

/* Bounces are not played: the cure itself is predicted with them. */
growth_prediction guess_steady(const rig &linear)
{
    if (!left_out_when_small(linear).empty()) {
        return predict_unscheduled(linear);
    }
    const double growth_per_s = std::log(guessed_spectral_radius(linear)) / config_period_s(&linear.firmware);
    return prediction_of(growth_per_s, linear, prediction_source::eigenvalues);
}

growth_prediction worse(const growth_prediction &a, const growth_prediction &b)
{
    return b.growth_per_s && !(a.growth_per_s.value_or(*b.growth_per_s) > *b.growth_per_s) ? b : a;
}

/* Rough: of a loop that changes from tick to tick from a shorter sequence than decides, or from none at all. */
growth_prediction guess_growth(const rig &rig)
try {
    constexpr std::int64_t guessed_ticks = 8000;
    if (!is_time_varying(rig)) {
        const growth_prediction held = guess_steady(in_contact(rig));
        return rig.object.kind == object_kind::contact ? worse(held, guess_steady(in_free_flight(rig))) : held;
    }
    if (rig.firmware.arm.kind != ARM_NONE || compensation_is_on(&rig.firmware)) {
        return predict_unscheduled(without_variation(rig));
    }
    const lyapunov_exponent found = exponent_of(in_contact(rig), load_wake_histogram(rig), guessed_ticks);
    return {found.growth_per_s, {}, found.ci95_per_s, prediction_source::lyapunov_exponent};
} catch (const input_error &error) {
    return {{}, error.what()};
}

} // namespace

std::optional<near_limit> nearest_limit(const std::vector<parameter_limits> &parameters, bool is_stable)
{
    std::optional<near_limit> nearest;
    for (const parameter_limits &parameter : parameters) {
        for (const stability_limit *const limit : limits_beside(parameter, is_stable)) {
            if ((limit->is_rough && !is_stable) || !(limit->value > 0.0)) {
                continue; /* no factor leads there */
            }
            const near_limit candidate{std::string(parameter.key), parameter.value, parameter.centre, *limit};
            if (!nearest || is_nearer(candidate, *nearest)) {
                nearest = candidate;
            }
        }
    }
    return nearest;
}

std::optional<cure> find_compensation(const rig &of, const growth_predictor &predict)
{
    std::optional<cure> weak;
    for (const known_compensation &known : compensations_for(of)) {
        rig with = of;
        bool is_possible = true;
        for (const auto &[key, text] : known.settings) {
            is_possible = is_possible && !set_value(with, key, text);
        }
        if (!is_possible || complete_and_check(with)) {
            continue;
        }
        const growth_prediction found = predict(with);
        if (is_stable(found) != std::optional<bool>(true)) {
            continue;
        }
        if (!is_weak(*found.growth_per_s)) {
            return cure{known.option, *found.growth_per_s};
        }
        weak = weak ? weak : cure{known.option, *found.growth_per_s};
    }
    return weak;
}

std::optional<parameter_cure> change_to(const rig &rig, const near_limit &limit, const growth_predictor &predict)
{
    constexpr int digits = 4;
    return tried_cure(rig, limit.key, rounded_beyond(limit.limit.value, limit.value, digits), predict);
}

stability_advice advise(const rig &rig, const growth_predictor &predict)
try {
    if (!effects_of_size(in_contact(rig)).empty() || is_too_long(rig)) {
        return {}; /* the one takes another loop at each amplitude, the other minutes */
    }
    stability_advice found;
    found.was_sought = true;
    found.compensation = find_compensation(rig, predict);
    if (has_limits(rig)) {
        found.change = change_by_limits(rig, predict, advice_scan, true);
        if (!found.change && !found.compensation) {
            found.change = change_by_limits(rig, predict, wide_advice_scan, false);
        }
    } else {
        const growth_predictor guess = [](const berth::rig &at) {
            return worst_of_schedule(at, guess_growth).prediction;
        };
        found.change = nearest_cure(rig, guess, predict);
    }
    return found;
} catch (const input_error &) {
    return {};
}

std::string advice_text(const stability_advice &advice)
{
    char text[120];
    std::string all;
    if (const auto &change = advice.change) {
        std::snprintf(text, sizeof text, "%s %s %.6g", change->key.c_str(),
                      change->value > change->own ? "above" : "below", change->value);
        all = text + (advice.caveat.empty() ? "" : " " + advice.caveat);
    }
    if (advice.compensation) {
        std::snprintf(text, sizeof text, "%s%s: %+.2g /s", all.empty() ? "" : ", or ",
                      advice.compensation->option.c_str(), advice.compensation->growth_per_s);
        all += text;
        if (is_weak(advice.compensation->growth_per_s)) {
            std::snprintf(text, sizeof text, ", barely stable: halves every %.0f s",
                          std::log(2.0) / -advice.compensation->growth_per_s);
            all += text;
        }
    }
    return all.empty() && advice.was_sought
               ? "no single parameter and no compensation that was tried makes it stable"
               : all;
}

} // namespace berth
