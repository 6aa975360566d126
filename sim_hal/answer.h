/* What the model answers on a rig: the same for every command. */
#ifndef SIM_HAL_ANSWER_H
#define SIM_HAL_ANSWER_H

#include "advice.h"
#include "margin.h"
#include "schedule.h"
#include "verdict.h"

namespace berth
{

struct model_answer {
    scheduled_loop worst;    /* the rig itself, or the worst loop of its schedule; prediction and margin are of it */
    stability_advice advice; /* of a loop that grows: changes of the rig that make all of its schedule stable */
    stability_margin margin; /* of one that does not */

    stability_verdict verdict() const { return judge(worst.prediction, advice); }
};

/* `predict`: of a rig with nothing scheduled. */
model_answer answer_of(const rig &rig, const growth_predictor &predict = predict_unscheduled);

} // namespace berth

#endif
