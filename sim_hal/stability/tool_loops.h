/* The two loops of a tool that may touch and leave: in each of them small motions are linear. */
#ifndef SIM_HAL_STABILITY_TOOL_LOOPS_H
#define SIM_HAL_STABILITY_TOOL_LOOPS_H

#include "../../hal/rig/rig.h"

namespace berth
{

/* Held to the material; other rigs as they are. */
rig in_contact(const rig &rig);

/* Away from it: the sensor feels the inertia of the tool beyond it, which closes the loop as well. Of
 * object.kind = "contact". */
rig in_free_flight(const rig &rig);

} // namespace berth

#endif
