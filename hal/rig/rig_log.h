/* What every log of a rig starts with, whichever HAL carries the loop. */
#ifndef HAL_RIG_RIG_LOG_H
#define HAL_RIG_RIG_LOG_H

#include "../log_file.h"
#include "rig.h"

namespace berth
{

/* Program, configuration, and the topics that the firmware records for such a rig; a HAL adds its own. */
log_header rig_log_header(const rig &rig);

} // namespace berth

#endif
