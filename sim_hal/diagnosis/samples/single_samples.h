/* When to look for what happened to single samples, and when to believe it. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_SINGLE_SAMPLES_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_SINGLE_SAMPLES_H

#include "../search/block_diagnosis.h"

namespace berth
{

/* Single samples first, as they would spoil every fit; and once more with a base that they no longer spoil. What is
 * found is looked for in the validation record, too. */
void find_single_samples(block block, const diagnosis_input &input, const rig &given, events_of_records &events,
                         std::vector<event_finding> &found);

/* What looked like spikes may have been corners of an effect that is known now, and others may have hidden behind
 * it. True: the rows are others now, so that the search is to be run again. */
bool verify_spikes(block block, const diagnosis_input &input, const block_diagnosis &result,
                   events_of_records &events, std::vector<event_finding> &found);

/* Of the explainable error of the fit, what is less of it as the rows of this finding are known; not a number where
 * a replay does not know of them, as of rounding, or nothing can be explained. `extended`: the rig of that replay.
 */
double share_explained_by(const event_finding &found, block block, const diagnosis_input &input, const rig &given,
                          const rig &extended, const sample_events &events, double floor_rms);

} // namespace berth

#endif
