/* The model that is written, with all causes of all blocks, run again on data that no fit has seen. */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_WRITTEN_MODEL_H
#define SIM_HAL_DIAGNOSIS_SEARCH_WRITTEN_MODEL_H

#include "block_diagnosis.h"

namespace berth
{

/* Its gain and how sure it is, by this evidence. */
void say_of(cause &known, const cause_evidence &evidence);

struct written_records {
    const record &fit;
    const record *validation; /* nullptr: parts of `fit` are held out */
    const events_of_records &events;
    int replays_max;
};

/* What is said of each cause that was fitted is what `extended` gains with it, against the same without it. A cause
 * with which it gains nothing is withdrawn, and the others are judged again without it. Rivals have
 * to have a size and to gain, however little sure. */
void judge_written_model(std::vector<block_diagnosis> &blocks, rig &extended, const written_records &records);

} // namespace berth

#endif
