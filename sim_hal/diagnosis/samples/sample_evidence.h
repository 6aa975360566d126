/* Whether what is said to have happened to single samples explains the error, on data that no fit has seen. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_SAMPLE_EVIDENCE_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_SAMPLE_EVIDENCE_H

#include "../decide/printable.h"
#include "../search/block_diagnosis.h"

namespace berth
{

/* Beside what else was found in this block. A stretch counts if such a sample is in it. Its error with them has
 * their price: each is one value that is told and not predicted, and which one it is was told too, unless the data
 * themselves say so. Of steps: how far the readings are from the nearest one, and from any. */
cause_evidence evidence_of_samples(const event_finding &found, const block_diagnosis &result,
                                   const diagnosis_input &input, const rig &given, const events_of_records &events);

} // namespace berth

#endif
