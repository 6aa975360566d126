#include "answer.h"

namespace berth
{

model_answer answer_of(const rig &rig, const growth_predictor &predict)
{
    model_answer made{worst_of_schedule(rig, predict), {}, {}};
    if (is_stable(made.worst.prediction) == std::optional<bool>(false)) {
        made.advice = advise(rig, [&](const berth::rig &at) { return worst_of_schedule(at, predict).prediction; });
    } else {
        made.margin = margin_of(made.worst.rig);
    }
    return made;
}

} // namespace berth
