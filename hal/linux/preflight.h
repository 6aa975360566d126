/* `berth-target --check`: what this machine is fit for, and what to do about the rest. */
#ifndef HAL_LINUX_PREFLIGHT_H
#define HAL_LINUX_PREFLIGHT_H

#include "../rig/rig.h"

namespace berth
{

/* Prints one line a finding. False: something is missing without which the loop cannot move the robot. */
bool print_preflight(const rig &rig);

} // namespace berth

#endif
