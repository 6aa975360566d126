/* Limits of a tool that may touch and leave: of the loop in contact, and of its bounces. */
#ifndef SIM_HAL_BOUNCE_LIMITS_H
#define SIM_HAL_BOUNCE_LIMITS_H

#include "../hal/rig/rig.h"
#include "stability/limits.h"

namespace berth
{

/* From value to value by this factor: a narrower part may be overlooked. */
constexpr double fine_bounce_step = 1.1;
constexpr double coarse_bounce_step = 1.3; /* for an answer in a moment */

/* Cuts from the stable intervals of the loop in contact what makes a bounce gain energy; the ends of those parts
 * become limits. Other rigs have no bounces: nothing changes. Relative accuracy 1e-4. Throws input_error. */
void cut_by_bounces(parameter_limits &limits, const rig &rig, double step = fine_bounce_step);

} // namespace berth

#endif
