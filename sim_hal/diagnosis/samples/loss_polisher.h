/* Which setpoints were lost, where what each does is not the sum of traces: by replays. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_LOSS_POLISHER_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_LOSS_POLISHER_H

#include "../replay/block_model.h"
#include "loss_trace.h"

namespace berth
{

/* `events.lost_command` are nearly right, and within the tick in which a play is crossed or a limit is left a loss
 * is no trace: where the error stands far above the rest of it, setpoints before it are taken for the opposite of
 * what they were, alone and with a neighbour, as long as that explains `least` squares of sigma each. `events` are
 * those of `model`. */
void polish_losses(block_model &model, const rig &rig, const loss_trace &loss, double least, sample_events &events);

} // namespace berth

#endif
