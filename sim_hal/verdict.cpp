#include "verdict.h"

#include <algorithm>
#include <cmath>

#include "tendency.h"
#include "verdict_kinds.h"
#include "verdict_words.h"

namespace berth
{

namespace
{

/* Limits that act in more ticks than this have the motion to themselves. */
constexpr double held_share = 0.5;

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

/* Limits act to the end of a motion that nobody drives, and its force does not fall: they hold what grows. */
bool is_held_by_limits(const motion_evidence &motion)
{
    const bool moves_by_itself = !motion.is_driven && !motion.is_ordered && !motion.is_contact;
    return moves_by_itself && motion.limits_acted_late && !motion.falls && motion.limited_share > held_share &&
           motion.height_m > 0.0 && !motion.force_falls;
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

/* What a run that was stopped shows of growth, though the model says that it decays. A motion that never swung has
 * not grown, however far it went. */
bool contradicts_decay(const motion_evidence &motion)
{
    const bool is_by_reflex = motion.stop.cause == STOP_GROWTH || motion.stop.cause == STOP_DEAD_TIME_POWER;
    return (is_by_reflex && !motion.is_driven) || (grew_until_stopped(motion) && !motion.is_too_short);
}

stability_verdict judge_motion(const verdict_case &of)
{
    const motion_evidence &motion = of.motion;
    const tendency model = tendency_of(of.prediction);
    const tendency seen = tendency_of(motion);
    if (motion.stop.cause == STOP_NOT_FINITE || (motion.stop.is_of_motion() && model == tendency::grows)) {
        return unstable_verdict(of);
    }
    if (motion.led && motion.led->rattles()) {
        return unstable_verdict(of);
    }
    if (grew_until_stopped(motion) && model == tendency::unknown) {
        return unstable_verdict(of);
    }
    if (const auto bounces = bounces_of(of.motion, of.manipulator_mass_kg);
        bounces && is_bouncing(motion) && (!motion.stop.is_of_motion() || has_drifted_off(motion))) {
        return bounce_verdict(of, *bounces);
    }
    if (swings_for_ever(of)) {
        return limit_cycle_verdict(of);
    }
    if (seen == tendency::grows || model == tendency::grows) {
        return unstable_verdict(of);
    }
    if (model == tendency::unknown && is_held_by_limits(motion)) {
        return unstable_verdict(of);
    }
    if (seen == tendency::decays && !motion.limits_acted_late) {
        return stable_verdict(of);
    }
    if (motion.stop.is_early() && (model != tendency::decays || contradicts_decay(motion))) {
        return stopped_early(of);
    }
    if (motion.is_driven || (motion.is_ordered && model != tendency::unknown)) {
        return driven_verdict(of);
    }
    if (model == tendency::decays || falls_under_limits(motion)) {
        return stable_verdict(of);
    }
    const bool is_judged_whole = !motion.growth && !motion.limits_acted_late && !motion.is_ordered &&
                                 !motion.is_too_short && motion.has_moved;
    if (is_judged_whole && motion.trend == motion_trend::moves_more) {
        return unstable_verdict(of);
    }
    return is_judged_whole && motion.trend == motion_trend::comes_to_rest ? stable_verdict(of) : not_told(of);
}

} // namespace

stability_verdict judge(const verdict_case &of)
{
    if (auto found = judge_without_motion(of)) {
        if (of.motion.stop.is_early()) {
            found->stop = of.motion.stop;
        }
        return *found;
    }
    stability_verdict found = judge_motion(of);
    if (found.kind != verdict_kind::limit_cycle) { /* which says so itself */
        found.because += limited_words(of.motion);
    }
    found.because += led_words(of.motion);
    const bool rattles = of.motion.led && of.motion.led->rattles(); /* which bounds what grows */
    if (found.kind != verdict_kind::limit_cycle && !found.bounces &&
        !rattles) { /* whose growth is none of one mode */
        found.caveat = caveat_words(of.motion, of.prediction);
    }
    if (of.motion.stop.is_early()) {
        found.stop = of.motion.stop;
        found.because += "; " + stop_words(of.motion.stop);
    }
    return found;
}

stability_verdict judge(const growth_prediction &prediction, const stability_advice &advice)
{
    stability_verdict found;
    if (prediction.never_touches && !prediction.grows_in_flight()) {
        return never_touches(prediction);
    }
    if (prediction.gains_by_bounces() && held_tendency_of(prediction) != tendency::grows) {
        found.kind = verdict_kind::unstable;
        found.is_stable = false;
        found.because = with_prediction(gaining_words(prediction), prediction);
        found.advice = advice_text(advice);
        return found;
    }
    if (!prediction.growth_per_s) {
        return undetermined(prediction.why_not, "ask `berth run`");
    }
    found.growth = predicted_finding(prediction);
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
