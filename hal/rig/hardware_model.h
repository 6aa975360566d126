/* What a rig file tells the firmware of the hardware. */
#ifndef HAL_RIG_HARDWARE_MODEL_H
#define HAL_RIG_HARDWARE_MODEL_H

#include "rig.h"

namespace berth
{

/* The rig must have been checked. */
hardware_model hardware_model_of(const rig &rig);

} // namespace berth

#endif
