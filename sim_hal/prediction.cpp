#include "prediction.h"

#include <algorithm>
#include <cmath>

#include "../firmware/compensation/compensation.h"
#include "../hal/rig/rig_file.h"
#include "bounce.h"
#include "compensated.h"
#include "effects/active.h"
#include "schedule.h"
#include "stability/dominant_root.h"
#include "stability/loop_timeline.h"
#include "stability/lyapunov.h"
#include "stability/spectrum.h"
#include "stability/tool_loops.h"

namespace berth
{

namespace
{

/* Eigenvalues leave a rounding of about 1e-9 of |z| - 1, at 1 kHz a growth of 1e-6 /s. */
constexpr double neutral_per_s = 1e-6;

/* Moves z = 1 by this much where it is a double eigenvalue. */
constexpr double drift_rounding_per_s = 1e-3;

bool has_loop_equation(const rig &rig)
{
    return !compensation_is_on(&rig.firmware) && rig.firmware.arm.kind == ARM_NONE && !is_time_varying(rig);
}

growth_prediction eigenvalue_growth(const rig &rig, prediction_source source)
{
    const loop_equation equation = make_loop_equation(without_variation(rig));
    if (equation.degree() > predicted_degree_max) {
        return {{},
                "the loop has " + std::to_string(equation.degree()) + " eigenvalues, for more than " +
                    std::to_string(predicted_degree_max) + " ask `berth eigen`"};
    }
    const double growth_per_s =
        std::log(dominant_root_finder().spectral_radius(equation)) / config_period_s(&rig.firmware);
    return prediction_of(growth_per_s, rig, source);
}

growth_prediction predict_held(const rig &rig)
try {
    const bool touches = rig.object.kind == object_kind::contact;
    if (const std::vector<std::string> left_out = left_out_when_small(in_contact(rig)); !left_out.empty()) {
        return {{}, left_out.front()};
    }
    const berth::rig linear = in_contact(rig);
    const prediction_source source = touches ? prediction_source::contact : prediction_source::eigenvalues;
    if (compensation_is_on(&rig.firmware) || rig.firmware.arm.kind != ARM_NONE) {
        if (is_time_varying(rig) && rig.firmware.arm.kind != ARM_NONE) {
            return {{},
                    "what changes from period to period is reckoned with a manipulator of one degree of freedom "
                    "alone"};
        }
        if (is_time_varying(rig)) {
            return predict_compensated(rig); /* neither eigenvalues nor an exponent: by a run */
        }
        return {loop_spectrum(without_variation(linear)).growth_per_s, {}, 0.0, source};
    }
    if (is_time_varying(rig) && make_loop_equation(without_variation(linear)).degree() <= predicted_degree_max) {
        const lyapunov_exponent found = exponent_of(linear, load_wake_histogram(rig));
        return {found.growth_per_s, {}, found.ci95_per_s, prediction_source::lyapunov_exponent, found.ticks, {}};
    }
    return eigenvalue_growth(linear, source);
} catch (const input_error &error) {
    return {{}, error.what()};
}

} // namespace

growth_prediction prediction_of(double growth_per_s, const rig &linear, prediction_source source)
{
    if (drifts_freely(linear) && growth_per_s < drift_rounding_per_s) {
        return {{}, "no spring holds manipulator or object: they may drift together for ever (z = 1)"};
    }
    return {growth_per_s, {}, 0.0, source};
}

std::optional<bool> is_stable_in_contact(const growth_prediction &prediction)
{
    const double growth_per_s = prediction.growth_per_s.value_or(0.0);
    if (!(std::abs(growth_per_s) > std::max(prediction.ci95_per_s, neutral_per_s))) {
        return {};
    }
    return growth_per_s < 0.0;
}

std::optional<bool> is_stable(const growth_prediction &prediction)
{
    return prediction.gains_by_bounces() ? false : is_stable_in_contact(prediction);
}

growth_prediction predict_growth(const rig &rig)
{
    return worst_of_schedule(rig, predict_unscheduled).prediction;
}

growth_prediction predict_unscheduled(const rig &rig)
try {
    growth_prediction found = predict_held(rig);
    add_flight(found, rig);
    add_bounces(found, rig);
    return found;
} catch (const input_error &error) {
    return {{}, error.what()};
}

void add_flight(growth_prediction &held, const rig &rig)
{
    if (rig.object.kind != object_kind::contact) {
        return;
    }
    const berth::rig flight = in_free_flight(rig);
    const growth_prediction found = predict_held(flight);
    const double noticeable_per_s = drifts_freely(flight) ? drift_rounding_per_s : 0.0;
    const bool grows = is_stable(found) == std::optional<bool>(false) && *found.growth_per_s > noticeable_per_s;
    if (grows && is_stable_in_contact(held) != std::optional<bool>(false)) {
        held.growth_per_s = found.growth_per_s;
        held.ci95_per_s = found.ci95_per_s;
        held.source = prediction_source::free_flight;
        held.ticks = found.ticks;
        held.why_not.clear();
    }
}

void add_bounces(growth_prediction &held, const rig &rig)
{
    if (rig.object.kind != object_kind::contact) {
        return;
    }
    held.never_touches = !comes_to_surface(rig);
    if (rig.firmware.arm.kind != ARM_NONE) {
        return; /* whose bounces are not played */
    }
    if (const auto bounce = play_bounce(rig)) {
        held.restitution = bounce->restitution;
    }
}

std::vector<limit_cycle> predict_cycles(const rig &rig, double height_m)
try {
    const bool is_known = has_loop_equation(rig) && !effects_of_size(rig).empty() && !is_slow_to_find(rig);
    return is_known && height_m > 0.0 ? limit_cycles(rig, 0.5 * height_m) : std::vector<limit_cycle>();
} catch (const input_error &) {
    return {};
}

} // namespace berth
