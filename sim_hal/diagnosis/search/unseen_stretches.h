/* What a cause gains on rows that no fit has seen. */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_UNSEEN_STRETCHES_H
#define SIM_HAL_DIAGNOSIS_SEARCH_UNSEEN_STRETCHES_H

#include "../decide/printable.h"
#include "../replay/block_model.h"

namespace berth
{

struct two_rigs {
    const rig &with; /* the cause */
    const rig &without;
};

/* Adds the stretches of the rows with this use that show the cause, of so many. */
void add_stretches(cause_evidence &made, block_model &model, row_use use, const two_rigs &rigs, double noise_rms,
                   std::size_t stretches);

} // namespace berth

#endif
