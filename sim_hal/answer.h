/* What the model answers on a rig: the same for every command. */
#ifndef SIM_HAL_ANSWER_H
#define SIM_HAL_ANSWER_H

#include "advice.h"
#include "margin.h"
#include "schedule.h"
#include "verdict.h"

namespace berth
{

/* Margin and advice may take seconds: thousands of runs do without. */
enum class answer_scope { whole, verdict_alone };

struct model_answer {
    scheduled_loop worst;    /* the rig itself, or the worst loop of its schedule; prediction and margin are of it */
    stability_advice advice; /* of a loop that grows: changes of the rig that make all of its schedule stable */
    stability_margin margin; /* of one that does not */
    std::optional<stability_verdict>
        by_runs; /* of a swing whose fate hangs on its size, or that has no eigenvalues */

    stability_verdict verdict() const { return by_runs ? *by_runs : judge(worst.prediction, advice); }
};

/* `predict`: of a rig with nothing scheduled; empty: what suits the rig. `amplitude_m`: of the swing, where it
 * depends on that; nothing: the rig's own in runs, else the usual one; 0: small motions. */
model_answer answer_of(const rig &rig, const growth_predictor &predict = {}, std::optional<double> amplitude_m = {},
                       answer_scope scope = answer_scope::whole);

} // namespace berth

#endif
