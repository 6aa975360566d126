#include "answer.h"

#include "compensated.h"
#include "loop_at_amplitude.h"
#include "run_advice.h"
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

} // namespace

model_answer answer_of(const rig &rig, const growth_predictor &given, std::optional<double> amplitude_m,
                       answer_scope scope)
{
    const double size_m = amplitude_of(rig, amplitude_m);
    const bool by_runs = amplitude_m != 0.0 && is_told_by_runs(rig);
    const auto predict_by_run = [&](const berth::rig &at) { return predict_compensated(at, amplitude_m); };
    const growth_predictor predict = by_runs && has_schedule(rig)  ? growth_predictor(predict_by_run)
                                     : given                       ? given
                                     : has_equivalent(rig, size_m) ? predictor_at(size_m)
                                                                   : growth_predictor(predict_unscheduled);
    model_answer made{worst_of_schedule(rig, predict), {}, {}, {}};
    const berth::rig &worst = made.worst.rig;
    if (by_runs) {
        made.by_runs = verdict_by_runs(worst, amplitude_m);
        if (scope == answer_scope::whole && made.by_runs->is_stable != std::optional<bool>(false)) {
            made.margin = margin_of(worst, amplitude_m);
        }
        if (scope == answer_scope::whole && made.by_runs->is_stable == std::optional<bool>(false)) {
            made.advice = advise_by_runs(rig);
            made.by_runs->advice = advice_text(made.advice);
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
