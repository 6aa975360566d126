/* What a block would have put out, had something else driven it. */
#ifndef SIM_HAL_DIAGNOSIS_REPLAY_OTHER_INPUT_H
#define SIM_HAL_DIAGNOSIS_REPLAY_OTHER_INPUT_H

#include "block_model.h"

namespace berth
{

/* rms, in the block's unit, of what the input in `other` instead of `recorded` makes of its output. */
double rms_of_other_input(block block, const record &recorded, const record &other, const rig &rig,
                          const sample_events &events);

} // namespace berth

#endif
