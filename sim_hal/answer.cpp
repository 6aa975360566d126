#include "answer.h"

#include "compensated.h"
#include "loop_at_amplitude.h"
#include "stability/compensation_states.h"

namespace berth
{

namespace
{

/* Small motions tell nothing of play and the like, which is judged by runs; other effects of size have an
 * equivalent. */
bool has_equivalent(const rig &rig, double amplitude_m)
{
    return amplitude_m > 0.0 && !is_judged_by_runs(rig) && !is_slow_to_find(rig);
}

/* What is small enough meets no limit of a drive: it grows as predicted, whatever becomes of the swing. What cures
 * it may leave the swing as it is. */
void advise_on_small(model_answer &made, const rig &original)
{
    rig small = original;
    small.robot.velocity_limit_m_per_s = small.robot.acceleration_limit_m_per_s2 = unlimited;
    if (is_stable(predict_growth(small)) != std::optional<bool>(false)) {
        return;
    }
    made.advice = advise(small);
    made.advice.compensation.reset(); /* was not tried with the limits */
    if (const auto &change = made.advice.change) {
        const auto cured = with_setting(original, change->key, change->value);
        const bool is_whole = cured && growth_of_compensated(*cured).is_stable();
        made.advice.caveat =
            is_whole ? "" : "for small motions; this rig's own swing meets the drive's limits all the same";
    } else {
        made.advice = {};
    }
    made.by_runs->advice = advice_text(made.advice);
}

} // namespace

model_answer answer_of(const rig &rig, const growth_predictor &given, std::optional<double> amplitude_m,
                       answer_scope scope)
{
    const double size_m = amplitude_of(rig, amplitude_m);
    const growth_predictor predict = given                         ? given
                                     : has_equivalent(rig, size_m) ? predictor_at(size_m)
                                                                   : growth_predictor(predict_unscheduled);
    model_answer made{worst_of_schedule(rig, predict), {}, {}, {}};
    const berth::rig &worst = made.worst.rig;
    if (amplitude_m != 0.0 && (is_judged_by_runs(worst) || !compensation_is_linear(worst))) {
        made.by_runs = verdict_by_runs(worst, amplitude_m);
        if (scope == answer_scope::whole && made.by_runs->is_stable != std::optional<bool>(false)) {
            made.margin = margin_of(worst, amplitude_m);
        }
        if (scope == answer_scope::whole && made.by_runs->is_stable == std::optional<bool>(false)) {
            advise_on_small(made, rig);
        }
        return made;
    }
    if (scope == answer_scope::verdict_alone) {
        return made;
    }
    if (is_stable(made.worst.prediction) == std::optional<bool>(false)) {
        made.advice = advise(rig, [&](const berth::rig &at) { return worst_of_schedule(at, predict).prediction; });
    } else {
        const bool is_equivalent = has_equivalent(rig, size_m) && made.worst.prediction.growth_per_s;
        made.margin = margin_of(is_equivalent ? linear_at(worst, size_m) : worst);
    }
    return made;
}

} // namespace berth
