/* What hangs on the force sensor in 1 g, as the sensor shows it. */
#ifndef HAL_RIG_TOOL_LOAD_H
#define HAL_RIG_TOOL_LOAD_H

#include <array>

#include "rig.h"

namespace berth
{

/* (force, torque) in the sensor's axes that holds the tool against gravity: N, N m. */
std::array<double, 6> tool_load(const tool_rig &tool);

/* What the firmware takes off: zero and tool. */
tare_config tare_of(const rig &rig);

} // namespace berth

#endif
