/* Which blocks a rig describes: of the others nothing is known that a record could contradict. */
#ifndef SIM_HAL_DIAGNOSIS_DESCRIBED_H
#define SIM_HAL_DIAGNOSIS_DESCRIBED_H

#include <string_view>

#include "diagnosis.h"

namespace berth
{

/* The section of the rig file without which there is nothing to judge a block by; empty: the block is described. A
 * force needs its robot, too, where the record has no position of it. */
std::string_view missing_section(const record &data, const rig &given, block which);

/* Notes that a block is not judged. */
void tell_not_described(diagnosis &result, block which, std::string_view section);

} // namespace berth

#endif
