#include "answer.h"

#include "compensated.h"
#include "stability/compensation_states.h"

namespace berth
{

model_answer answer_of(const rig &rig, const growth_predictor &predict, std::optional<double> amplitude_m,
                       answer_scope scope)
{
    model_answer made{worst_of_schedule(rig, predict), {}, {}, {}};
    const berth::rig &worst = made.worst.rig;
    if (amplitude_m != 0.0 && (is_judged_by_runs(worst) || !compensation_is_linear(worst))) {
        made.by_runs = verdict_by_runs(worst, amplitude_m);
        if (scope == answer_scope::whole && made.by_runs->is_stable != std::optional<bool>(false)) {
            made.margin = margin_of(worst, amplitude_m);
        }
        return made;
    }
    if (scope == answer_scope::verdict_alone) {
        return made;
    }
    if (is_stable(made.worst.prediction) == std::optional<bool>(false)) {
        made.advice = advise(rig, [&](const berth::rig &at) { return worst_of_schedule(at, predict).prediction; });
    } else {
        made.margin = margin_of(made.worst.rig);
    }
    return made;
}

} // namespace berth
