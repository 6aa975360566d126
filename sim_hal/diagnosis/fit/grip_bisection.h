/* The size of a grip by the first moment at which it is wrong. */
#ifndef SIM_HAL_DIAGNOSIS_FIT_GRIP_BISECTION_H
#define SIM_HAL_DIAGNOSIS_FIT_GRIP_BISECTION_H

#include "../replay/block_model.h"

namespace berth
{

/* As long as all is as it was measured, the first error that stands out says whether the grip is too strong (the
 * model still pulls where nothing is measured) or too weak (the other way round): its size is bisected, with no luck
 * needed. `held`: a rig that is right while the object is held; returned with the grip that is right for longest.
 * `size_key`: of the grip, in N; `most_N`: no pull is larger. */
rig with_bisected_grip(block_model &model, const noise_model &noise, rig held, std::string_view size_key,
                       double most_N);

} // namespace berth

#endif
