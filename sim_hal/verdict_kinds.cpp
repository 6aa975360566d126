#include "verdict_kinds.h"

#include "tendency.h"
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

growth_finding measured(const growth_fit &fit)
{
    return {growth_origin::measured, fit.growth_per_s, fit.growth_ci95_per_s, fit.frequency_Hz};
}

/* Its eigenvalues lie on the unit circle, but for rounding. */
bool is_neutral(const growth_prediction &prediction)
{
    const bool is_exact =
        prediction.source == prediction_source::eigenvalues || prediction.source == prediction_source::contact;
    return is_exact && prediction.growth_per_s && !is_stable_in_contact(prediction);
}

/* Empty of a stop that somebody ordered. */
std::string advice_against(const run_stop &stop)
{
    if (stop.is_of_motion()) {
        return "widen the limit (limits.*, sensor_channel.force_limit_N) or start from less "
               "(manipulator.initial_position_m, profile.amplitude_*)";
    }
    return stop.is_ordered() ? "" : "remove what stopped it: " + words_of(stop.cause);
}

std::string neutral_words(const growth_prediction &prediction)
{
    return predicted_words(prediction) + ": no more than rounding, so that it neither decays nor grows";
}

} // namespace

growth_finding predicted_finding(const growth_prediction &prediction)
{
    const bool is_of_run = prediction.source == prediction_source::run;
    return {is_of_run ? growth_origin::trial : growth_origin::predicted, *prediction.growth_per_s,
            prediction.ci95_per_s, 0.0};
}

stability_verdict undetermined(std::string because, std::string advice)
{
    stability_verdict found;
    found.because = std::move(because);
    found.advice = std::move(advice);
    return found;
}

/* A bounce that loses leaves the tool in the material in the end: there the eigenvalues rule. */
stability_verdict bounce_verdict(const verdict_case &of, const bounce_finding &bounces)
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
    if (bounces.is_driven && of.prediction.restitution && !of.prediction.gains_by_bounces()) {
        found.because += with_numbers("; by itself a bounce returns %.3g of its speed", *of.prediction.restitution);
    }
    if (!found.is_stable) {
        found.because += "; whether a tool that stays in contact is stable is not predicted" +
                         (of.prediction.why_not.empty() ? "" : ": " + of.prediction.why_not);
        found.advice = "ask `berth eigen`, which holds the tool to the material";
        return found;
    }
    if (!*found.is_stable) { /* the word that the model alone has for it */
        found.kind = verdict_kind::unstable;
        found.advice = advice_text(of.advice);
    }
    if (held == tendency::grows) {
        found.growth = predicted_finding(of.prediction);
    }
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

/* Of what grows, though neither the model nor a decrement says so. */
std::string unpredicted_words(const motion_evidence &motion)
{
    if (motion.led && motion.led->rattles()) {
        return "the force that the loop uses grows from tick to tick";
    }
    if (motion.limits_acted_late && !motion.stop.is_early()) {
        return "limits hold what grows: its force does not fall";
    }
    return motion.trend == motion_trend::moves_more ? "it moves more and more" : "its force grows";
}

stability_verdict unstable_verdict(const verdict_case &of)
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
        found.because = with_prediction(gaining_words(of.prediction), of.prediction) + not_shown_words(motion);
    } else if (model == tendency::grows) {
        found.growth = predicted_finding(of.prediction);
        found.because = predicted_words(of.prediction) + factor_words(*found.growth) + motor_words(motion);
        const bool rattles = motion.led && motion.led->rattles();
        found.because += rattles ? ""
                         : tendency_of(motion) == tendency::decays
                             ? "; the motion of this run still decays: what grows has not come up yet, a longer run "
                               "shows it"
                             : not_shown_words(motion);
    } else {
        found.because = unpredicted_words(motion);
    }
    if (is_seen && model == tendency::decays) {
        found.because += beyond_words(of.prediction);
    } else if (is_seen && of.prediction.growth_per_s) {
        found.because += "; " + predicted_words(of.prediction);
    }
    found.advice = advice_text(of.advice);
    return found;
}

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

stability_verdict limit_cycle_verdict(const verdict_case &of)
{
    const motion_evidence &motion = of.motion;
    stability_verdict found;
    found.kind = verdict_kind::limit_cycle;
    found.is_stable = false;
    found.because = with_numbers("it swings for ever at a height of %.3g mm", 1e3 * motion.height_m) +
                    (motion.swing_Hz > 0.0 ? with_numbers(" and %.4g Hz", motion.swing_Hz) : "") +
                    (motion.limits_acted_late ? ", held by the limits" : "");
    if (const auto cycle = cycle_of(of)) {
        found.because += with_numbers("; harmonic balance predicts %.3g mm at %.4g Hz", 2e3 * cycle->amplitude_m,
                                      cycle->frequency_Hz);
    }
    if (held_tendency_of(of.prediction) == tendency::grows) {
        found.growth = predicted_finding(of.prediction);
    }
    found.because = tendency_of(of.prediction) == tendency::decays ? found.because + beyond_words(of.prediction)
                                                                   : with_prediction(found.because, of.prediction);
    found.advice = advice_text(of.advice);
    return found;
}

bool falls_under_limits(const motion_evidence &motion)
{
    return motion.limits_acted_late && motion.falls == std::optional<bool>(true);
}

stability_verdict stable_verdict(const verdict_case &of)
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
    found.growth = predicted_finding(of.prediction);
    found.because = predicted_words(of.prediction) + factor_words(*found.growth);
    if (motion.stop.is_early()) {
        found.because += "; stable by prediction, as this run was stopped before it could show it";
        found.advice = advice_against(motion.stop);
        return found;
    }
    found.because += not_shown_words(motion);
    return found;
}

stability_verdict driven_verdict(const verdict_case &of)
{
    const motion_evidence &motion = of.motion;
    stability_verdict found;
    found.kind = verdict_kind::driven;
    found.because = tracking_words(motion.tracking);
    if (tendency_of(of.prediction) == tendency::decays) {
        found.is_stable = true;
        found.growth = predicted_finding(of.prediction);
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
    const std::string what = stop.is_of_motion() ? "the motion reached a limit" : "the run ended";
    const std::string advice = advice_against(stop);
    return undetermined(with_prediction(what + " before its growth could be measured", of.prediction),
                        advice.empty() ? "let it run on: " + words_of(stop.cause) + " ended it" : advice);
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

stability_verdict never_touches(const growth_prediction &prediction)
{
    return undetermined(with_prediction("the tool never comes to the object: there is no loop to judge", prediction),
                        never_touched_advice);
}

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

} // namespace berth
