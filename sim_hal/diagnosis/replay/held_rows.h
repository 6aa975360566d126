/* The rows of a record in which a gripped object hangs on the robot. */
#ifndef SIM_HAL_DIAGNOSIS_REPLAY_HELD_ROWS_H
#define SIM_HAL_DIAGNOSIS_REPLAY_HELD_ROWS_H

#include <optional>
#include <vector>

#include "block_model.h"

namespace berth
{

/* The uses of a model's rows without those in which the object is loose, bounces, or has just been caught: where no
 * force is measured for longer than one passes zero, while `rig`, whose grip holds, says that there is one, it is
 * loose. Once it has been held for a while it hangs on the robot again, whatever was before. Nothing where there are
 * hardly any such rows. Of the force's block. */
std::optional<std::vector<row_use>> uses_while_held(block_model &model, const rig &rig);

} // namespace berth

#endif
