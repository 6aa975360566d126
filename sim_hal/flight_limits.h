/* Limits of a tool that may touch and leave: of its loop away from the material. */
#ifndef SIM_HAL_FLIGHT_LIMITS_H
#define SIM_HAL_FLIGHT_LIMITS_H

#include "../hal/rig/rig.h"
#include "stability/limits.h"

namespace berth
{

/* Cuts from the stable intervals of the loop in contact what grows in free flight; the ends of those parts become
 * limits. Other rigs do not fly, and an arm's flight is left out, as is that of bodies that nothing holds: nothing
 * changes. */
void cut_by_flight(parameter_limits &limits, const rig &rig, const scan &how = fine_scan);

} // namespace berth

#endif
