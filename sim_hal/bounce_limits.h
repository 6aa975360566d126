/* Limits of a tool that may touch and leave: of the loop in contact, and of its bounces. */
#ifndef SIM_HAL_BOUNCE_LIMITS_H
#define SIM_HAL_BOUNCE_LIMITS_H

#include "../hal/rig/rig.h"
#include "stability/limits.h"

namespace berth
{

/* Cuts from the stable intervals of the loop in contact what makes a bounce gain energy; the ends of those parts
 * become limits. Other rigs have no bounces: nothing changes. Parts narrower than 25 % may be overlooked; relative
 * accuracy 1e-4. Throws input_error. */
void cut_by_bounces(parameter_limits &limits, const rig &rig);

} // namespace berth

#endif
