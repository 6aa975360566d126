/* The size of a limit or a dead band on whose way setpoints were lost: neither shows without the other. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_SWITCH_BESIDE_LOSSES_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_SWITCH_BESIDE_LOSSES_H

#include <optional>

#include "../search/block_diagnosis.h"

namespace berth
{

/* For each size of a grid that closes in the losses are decoded, at first in the beginning of the record, as a wrong
 * size leads all that follows astray, with the base tuned in between. `result`: of the robot's block without losses,
 * whose limits are looked at, and a dead band in place of its causes. Returns the given rig with the base and the
 * size that the losses explain best; nothing where they explain none well. */
std::optional<rig> switch_beside_losses(const diagnosis_input &input, const rig &given,
                                        const block_diagnosis &result);

} // namespace berth

#endif
