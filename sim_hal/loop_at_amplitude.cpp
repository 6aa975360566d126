#include "loop_at_amplitude.h"

#include <cmath>
#include <cstdio>

#include "../firmware/compensation/compensation.h"
#include "compensated.h"
#include "stability/arm_loop.h"
#include "stability/loop_timeline.h"
#include "stability/lyapunov.h"
#include "stability/spectrum.h"

namespace berth
{

double amplitude_of(const rig &rig, std::optional<double> asked_m)
{
    const bool is_asked_of_tool = asked_m.has_value() && rig.object.kind == object_kind::contact;
    const bool depends_on_size = is_asked_of_tool || !effects_of_size(rig).empty();
    return depends_on_size ? asked_m.value_or(usual_amplitude_m(rig)) : 0.0;
}

settled_rig settle_at(const rig &rig, double amplitude_m)
{
    if (!(amplitude_m > 0.0)) {
        return {in_contact(rig), true}; /* a tool stays in contact: small motions are linear there */
    }
    refuse_arm(rig); /* here, while the rig has its effects, which the words name */
    const equivalent_loop found = equivalent_finder(amplitude_m).find(rig);
    if (!std::isfinite(found.growth_per_s)) {
        char amplitude[32];
        std::snprintf(amplitude, sizeof amplitude, "%g", amplitude_m);
        throw input_error(
            std::string("--amplitude: at ") + amplitude +
            " m the rig's effects are like no linear loop (a spring that softens to nothing?): choose a "
            "smaller amplitude, or ask berth run");
    }
    return {found.linear, found.has_settled};
}

rig linear_at(const rig &rig, double amplitude_m)
{
    return settle_at(rig, amplitude_m).linear;
}

growth_predictor predictor_at(double amplitude_m, std::int64_t ticks)
{
    return [=](const rig &at) -> growth_prediction {
        try {
            const settled_rig found = settle_at(at, amplitude_m);
            if (!found.has_settled) {
                return {{}, "the describing function did not settle: what it says is a guess"};
            }
            if (is_time_varying(at) && compensation_is_on(&at.firmware)) {
                return predict_compensated(at, amplitude_m);
            }
            if (is_time_varying(at)) {
                const lyapunov_exponent exponent = exponent_of(found.linear, load_wake_histogram(at), ticks);
                growth_prediction made{exponent.growth_per_s,
                                       {},
                                       exponent.ci95_per_s,
                                       prediction_source::lyapunov_exponent,
                                       exponent.ticks};
                if (amplitude_m == 0.0) {
                    add_flight(made, at);
                    add_bounces(made, at);
                }
                made.amplitude_m = amplitude_m;
                return made;
            }
            const bool is_held = at.object.kind == object_kind::contact && amplitude_m == 0.0;
            growth_prediction made =
                prediction_of(std::log(spectral_radius_of(found.linear)) / config_period_s(&at.firmware),
                              found.linear, is_held ? prediction_source::contact : prediction_source::eigenvalues);
            if (is_held) {
                add_flight(made, at);
                add_bounces(made, at);
            }
            made.amplitude_m = amplitude_m;
            return made;
        } catch (const input_error &error) {
            return {{}, error.what()};
        }
    };
}

} // namespace berth
