/* What `eigen` and `limits` tell of a loop with compensation of the dead time. */
#ifndef SIM_HAL_CLI_COMPENSATED_REPORT_H
#define SIM_HAL_CLI_COMPENSATED_REPORT_H

#include <string>
#include <vector>

#include "commands.h"

namespace berth
{

/* Of a compensation, or effects beside one, without eigenvalues. Both print, and return the exit code. */
int answer_compensated_growth(const rig &rig, const rig_arguments &arguments);

int answer_compensated_limits(const rig &rig, const rig_arguments &arguments);

} // namespace berth

#endif
