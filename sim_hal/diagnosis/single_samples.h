/* When to look for what happened to single samples, and when to believe it. */
#ifndef SIM_HAL_DIAGNOSIS_SINGLE_SAMPLES_H
#define SIM_HAL_DIAGNOSIS_SINGLE_SAMPLES_H

#include "block_diagnosis.h"

namespace berth
{

/* Single samples first, as they would spoil every fit; and once more with a base that they no longer spoil. */
void find_single_samples(block block, const diagnosis_input &input, const rig &given, sample_events &events,
                         std::vector<event_finding> &found);

/* What looked like spikes may have been corners of an effect that is known now. */
void verify_spikes(block block, const diagnosis_input &input, block_diagnosis &result, sample_events &events,
                   std::vector<event_finding> &found);

} // namespace berth

#endif
