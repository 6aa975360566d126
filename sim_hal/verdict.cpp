#include "verdict.h"

#include <algorithm>
#include <cmath>

#include "verdict_words.h"

namespace berth
{

namespace
{

constexpr const char *never_touched_advice = "move the tool beyond object.surface_position_m, or run longer "
                                             "(run.duration_s); a manipulator without spring and "
                                             "damper needs manipulator.initial_velocity_m_per_s";

constexpr const char *neutral_advice = "on balance nothing takes energy out: give it damping, as "
                                       "manipulator.damping_N_s_per_m; a longer run shows no more";

enum class tendency { unknown, decays, grows };

tendency tendency_of(double growth_per_s, double ci95_per_s)
{
    if (!(std::abs(growth_per_s) > std::max(ci95_per_s, 0.0))) {
        return tendency::unknown;
    }
    return growth_per_s < 0.0 ? tendency::decays : tendency::grows;
}

tendency tendency_of(const std::optional<bool> &decays)
{
    return !decays ? tendency::unknown : *decays ? tendency::decays : tendency::grows;
}

tendency held_tendency_of(const growth_prediction &prediction)
{
    return tendency_of(is_stable_in_contact(prediction));
}

tendency tendency_of(const growth_prediction &prediction)
{
    return tendency_of(is_stable(prediction));
}

/* What an operator moves tells nothing of what the loop does by itself. */
tendency tendency_of(const motion_evidence &motion)
{
    return motion.growth && !motion.is_driven
               ? tendency_of(motion.growth->growth_per_s, motion.growth->growth_ci95_per_s)
               : tendency::unknown;
}

growth_finding measured(const growth_fit &fit)
{
    return {growth_origin::measured, fit.growth_per_s, fit.growth_ci95_per_s, fit.frequency_Hz};
}

growth_finding predicted(const growth_prediction &prediction)
{
    return {growth_origin::predicted, *prediction.growth_per_s, prediction.ci95_per_s, 0.0};
}

stability_verdict undetermined(std::string because, std::string advice)
{
    stability_verdict found;
    found.because = std::move(because);
    found.advice = std::move(advice);
    return found;
}

/* Its eigenvalues lie on the unit circle, but for rounding. */
bool is_neutral(const growth_prediction &prediction)
{
    const bool is_exact =
        prediction.source == prediction_source::eigenvalues || prediction.source == prediction_source::contact;
    return is_exact && prediction.growth_per_s && !is_stable_in_contact(prediction);
}

std::string neutral_words(const growth_prediction &prediction)
{
    return predicted_words(prediction) + ": no more than rounding, so that it neither decays nor grows";
}

/* A bounce that loses leaves the tool in the material in the end: there the eigenvalues rule. */
stability_verdict judge_bounces(const verdict_case &of, const bounce_finding &bounces)
{
    stability_verdict found;
    found.kind = verdict_kind::bouncing;
    found.bounces = bounces;
    const tendency held = held_tendency_of(of.prediction);
    const bool gains = bounces.gains() || of.prediction.gains_by_bounces();
    if (gains || held != tendency::unknown) {
        found.is_stable = !gains && held == tendency::decays;
    }
    found.because = with_prediction(bounce_words(bounces, of.motion), of.prediction);
    found.because += gains && held == tendency::decays ? ", of a tool that stays in contact"
                     : !gains && held == tendency::grows && !of.prediction.grows_in_flight()
                         ? ": what stays in contact grows"
                         : "";
    found.because += relaxed_words(bounces, of.prediction);
    if (!found.is_stable) {
        found.because += "; whether a tool that stays in contact is stable is not predicted" +
                         (of.prediction.why_not.empty() ? "" : ": " + of.prediction.why_not);
        found.advice = "ask `berth eigen`, which holds the tool to the material";
        return found;
    }
    found.advice = found.is_stable == std::optional<bool>(true) ? "" : advice_text(of.advice);
    return found;
}

/* What is known before anything has been judged: the loop never ran, or never had its object. */
std::optional<stability_verdict> judge_without_motion(const verdict_case &of)
{
    const motion_evidence &motion = of.motion;
    if (!motion.has_run) {
        return undetermined(with_prediction("the supervisor never came to running" + of.obstacles, of.prediction),
                            "clear what keeps the loop from running");
    }
    if (motion.has_touched || of.prediction.grows_in_flight()) { /* nothing has to be touched for that */
        return {};
    }
    const std::string ran = with_numbers("it ran for %.2f s, but ", motion.running_s);
    return motion.is_contact
               ? undetermined(with_prediction(ran + "the tool never came to the object: there was no loop to judge",
                                              of.prediction),
                              never_touched_advice)
               : undetermined(with_prediction(ran + "never with the object gripped: there was no loop to judge",
                                              of.prediction),
                              "let run.grip_close_s lie within the run");
}

stability_verdict unstable(const verdict_case &of)
{
    const motion_evidence &motion = of.motion;
    stability_verdict found;
    found.kind = verdict_kind::unstable;
    found.is_stable = false;
    const bool is_seen = tendency_of(motion) == tendency::grows;
    const tendency model = tendency_of(of.prediction);
    if (is_seen) {
        found.growth = measured(*motion.growth);
        found.because = measured_words(*found.growth) + motor_words(motion);
    } else if (of.prediction.gains_by_bounces() && held_tendency_of(of.prediction) != tendency::grows) {
        found.kind = verdict_kind::bouncing;
        found.because = with_prediction(gaining_words(of.prediction), of.prediction) + not_shown_words(motion);
    } else if (model == tendency::grows) {
        found.growth = predicted(of.prediction);
        found.because = predicted_words(of.prediction) + factor_words(*found.growth) + motor_words(motion);
        found.because += tendency_of(motion) == tendency::decays
                             ? "; the motion of this run still decays: what grows has not come up yet, a longer run "
                               "shows it"
                             : not_shown_words(motion);
    } else {
        found.because = motion.trend == motion_trend::moves_more ? "it moves more and more" : "its force grows";
    }
    if (is_seen && model == tendency::decays) {
        found.because += beyond_words(of.prediction);
    } else if (is_seen && of.prediction.growth_per_s) {
        found.because += "; " + predicted_words(of.prediction);
    }
    found.advice = advice_text(of.advice);
    return found;
}

/* The predicted swing that a motion of this height is: within a factor of two, and one that motion comes to. */
std::optional<berth::limit_cycle> cycle_of(const verdict_case &of)
{
    constexpr double alike = 2.0;
    for (const berth::limit_cycle &cycle : of.cycles) {
        const double ratio = 2.0 * cycle.amplitude_m / of.motion.height_m;
        if (cycle.attracts && ratio < alike && ratio > 1.0 / alike) {
            return cycle;
        }
    }
    return {};
}

stability_verdict judge_limit_cycle(const verdict_case &of)
{
    const motion_evidence &motion = of.motion;
    stability_verdict found;
    found.kind = verdict_kind::limit_cycle;
    found.is_stable = false;
    found.because = with_numbers("it swings for ever at a height of %.3g mm", 1e3 * motion.height_m) +
                    (motion.limits_acted_late ? ", held by the limits" : "");
    if (const auto cycle = cycle_of(of)) {
        found.because += with_numbers("; harmonic balance predicts %.3g mm at %.4g Hz", 2e3 * cycle->amplitude_m,
                                      cycle->frequency_Hz);
    }
    if (held_tendency_of(of.prediction) == tendency::grows) {
        found.growth = predicted(of.prediction);
    }
    found.because = tendency_of(of.prediction) == tendency::decays ? found.because + beyond_words(of.prediction)
                                                                   : with_prediction(found.because, of.prediction);
    found.advice = advice_text(of.advice);
    return found;
}

/* Without limits at work, the growth tells more. */
bool falls_under_limits(const motion_evidence &motion)
{
    return motion.limits_acted_late && motion.falls == std::optional<bool>(true);
}

stability_verdict stable(const verdict_case &of)
{
    const motion_evidence &motion = of.motion;
    stability_verdict found;
    found.kind = verdict_kind::stable;
    found.is_stable = true;
    if (tendency_of(motion) == tendency::decays) {
        found.growth = measured(*motion.growth);
        found.because = with_prediction(measured_words(*found.growth) + motor_words(motion), of.prediction);
        return found;
    }
    if (tendency_of(of.prediction) != tendency::decays) {
        found.because =
            falls_under_limits(motion) ? "the motion falls although limits bound it" : "the motion comes to rest";
        found.because += motor_words(motion);
        return found;
    }
    found.growth = predicted(of.prediction);
    found.because = predicted_words(of.prediction) + factor_words(*found.growth) + not_shown_words(motion);
    return found;
}

stability_verdict driven(const verdict_case &of)
{
    const motion_evidence &motion = of.motion;
    stability_verdict found;
    found.kind = verdict_kind::driven;
    found.because = tracking_words(motion.tracking);
    if (tendency_of(of.prediction) == tendency::decays) {
        found.is_stable = true;
        found.growth = predicted(of.prediction);
        found.because = with_prediction(found.because, of.prediction) + factor_words(*found.growth);
        return found;
    }
    found.because += "; whether the loop is stable is not predicted: " + of.prediction.why_not;
    found.advice = "to see it, let the loop swing by itself: profile.kind = \"rest\"";
    return found;
}

stability_verdict stopped_early(const verdict_case &of)
{
    const run_stop &stop = of.motion.stop;
    if (stop.is_of_motion()) {
        return undetermined(
            with_prediction("the motion reached a limit before its growth could be measured", of.prediction),
            "widen the limit (limits.*, sensor_channel.force_limit_N) or start from less "
            "(manipulator.initial_position_m, profile.amplitude_*)");
    }
    return undetermined(with_prediction("the run ended before its growth could be measured", of.prediction),
                        "remove what stopped it: " + words_of(stop.cause));
}

stability_verdict not_told(const verdict_case &of)
{
    const motion_evidence &motion = of.motion;
    const std::string why = of.prediction.why_not.empty() ? "" : "; not predicted: " + of.prediction.why_not;
    if (!motion.has_moved) {
        return undetermined("nothing moved: there is no motion to judge" + why,
                            "move it: manipulator.initial_position_m or [profile]");
    }
    if (motion.growth && is_neutral(of.prediction)) {
        return undetermined("the swing keeps its height; " + neutral_words(of.prediction) + motor_words(motion),
                            neutral_advice);
    }
    if (motion.growth) {
        return undetermined(
            "whether it grows or decays is not known: the rate measured is smaller than its interval" +
                motor_words(motion) + why,
            "a longer run (run.duration_s) or less noise may tell");
    }
    if (motion.limits_acted_late) {
        return undetermined("limits bound the motion to its end: its fall may be theirs" + motor_words(motion) + why,
                            "widen limits.* or start from less, so that the loop swings freely");
    }
    return undetermined("there is too little oscillation to measure a growth rate" + motor_words(motion) + why,
                        "a longer run (run.duration_s) may show more");
}

/* A growth that is not told from 0. */
stability_verdict neither(const growth_prediction &prediction)
{
    switch (prediction.source) {
    case prediction_source::run:
        return undetermined("a run without noise neither grows nor decays", "let it swing further: --amplitude");
    case prediction_source::lyapunov_exponent:
        return undetermined(predicted_words(prediction) + ": its interval holds 0",
                            "ask `berth eigen` for more --ticks, or `berth run`");
    default:
        return undetermined(neutral_words(prediction), neutral_advice);
    }
}

bool ended_early(const run_stop &stop)
{
    return stop.cause != STOP_NONE && stop.cause != STOP_REQUESTED;
}

/* With limits acting to the end, or effects that depend on the size of the motion, a swing of constant height is one
 * that grew. */
bool swings_for_ever(const verdict_case &of)
{
    const motion_evidence &motion = of.motion;
    const bool is_predicted = tendency_of(of.prediction) == tendency::grows || cycle_of(of).has_value();
    const bool holds_height = motion.falls == std::optional<bool>(false) && motion.height_m > 0.0;
    const bool may_be_held = motion.limits_acted_late || (motion.has_effects_of_size && is_predicted);
    return holds_height && may_be_held && !motion.is_driven;
}

/* The tool left the material for good and came to a limit in free flight: the bounces had ended by then. */
bool has_drifted_off(const motion_evidence &motion)
{
    return motion.stop.cause == STOP_POSITION_LIMIT && !motion.touches_now;
}

/* Too large in the end, though nobody moved it, and larger than at first. */
bool grew_until_stopped(const motion_evidence &motion)
{
    const bool grew = motion.trend == motion_trend::moves_more || (motion.force_grows && !motion.is_contact);
    return motion.stop.is_of_motion() && grew && !motion.is_driven && !motion.is_ordered;
}

stability_verdict judge_motion(const verdict_case &of)
{
    const motion_evidence &motion = of.motion;
    const tendency model = tendency_of(of.prediction);
    const tendency seen = tendency_of(motion);
    if (motion.stop.cause == STOP_NOT_FINITE || (motion.stop.is_of_motion() && model == tendency::grows)) {
        return unstable(of);
    }
    if (grew_until_stopped(motion) && model == tendency::unknown) {
        return unstable(of);
    }
    if (const auto bounces = bounces_of(of.motion, of.manipulator_mass_kg);
        bounces && is_bouncing(motion) && (!motion.stop.is_of_motion() || has_drifted_off(motion))) {
        return judge_bounces(of, *bounces);
    }
    if (swings_for_ever(of)) {
        return judge_limit_cycle(of);
    }
    if (seen == tendency::grows || model == tendency::grows) {
        return unstable(of);
    }
    if (seen == tendency::decays && !motion.limits_acted_late) {
        return stable(of);
    }
    if (ended_early(motion.stop)) {
        return stopped_early(of);
    }
    if (motion.is_driven || (motion.is_ordered && model != tendency::unknown)) {
        return driven(of);
    }
    if (model == tendency::decays || falls_under_limits(motion)) {
        return stable(of);
    }
    const bool is_judged_whole = !motion.growth && !motion.limits_acted_late && !motion.is_ordered &&
                                 !motion.is_too_short && motion.has_moved;
    if (is_judged_whole && motion.trend == motion_trend::moves_more) {
        return unstable(of);
    }
    return is_judged_whole && motion.trend == motion_trend::comes_to_rest ? stable(of) : not_told(of);
}

} // namespace

stability_verdict judge(const verdict_case &of)
{
    if (auto found = judge_without_motion(of)) {
        if (ended_early(of.motion.stop)) {
            found->stop = of.motion.stop;
        }
        return *found;
    }
    stability_verdict found = judge_motion(of);
    if (ended_early(of.motion.stop)) {
        found.stop = of.motion.stop;
        found.because += "; " + stop_words(of.motion.stop);
    }
    return found;
}

stability_verdict judge(const growth_prediction &prediction, const stability_advice &advice)
{
    stability_verdict found;
    if (prediction.never_touches && !prediction.grows_in_flight()) {
        return undetermined(
            with_prediction("the tool never comes to the object: there is no loop to judge", prediction),
            never_touched_advice);
    }
    if (prediction.gains_by_bounces() && held_tendency_of(prediction) != tendency::grows) {
        found.kind = verdict_kind::bouncing;
        found.is_stable = false;
        found.because = with_prediction(gaining_words(prediction), prediction);
        found.advice = advice_text(advice);
        return found;
    }
    if (!prediction.growth_per_s) {
        return undetermined(prediction.why_not, "ask `berth run`");
    }
    found.growth = predicted(prediction);
    switch (tendency_of(prediction)) {
    case tendency::decays:
        found.kind = verdict_kind::stable;
        found.is_stable = true;
        break;
    case tendency::grows:
        found.kind = verdict_kind::unstable;
        found.is_stable = false;
        found.advice = advice_text(advice);
        break;
    default:
        return neither(prediction);
    }
    found.because = predicted_words(prediction) + factor_words(*found.growth);
    if (prediction.restitution) {
        found.because += with_numbers("; a bounce returns %.3g of its speed", *prediction.restitution);
    }
    return found;
}

bool is_safe(const stability_verdict &verdict, const stability_margin &margin, double margin_ms)
{
    if (verdict.is_stable != std::optional<bool>(true)) {
        return false;
    }
    return margin_ms <= 0.0 || margin.is_unlimited || margin.dead_time_ms.value_or(0.0) >= margin_ms;
}

} // namespace berth
