/* Effects that the rig file has already. */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_AS_GIVEN_H
#define SIM_HAL_DIAGNOSIS_SEARCH_AS_GIVEN_H

#include "block_diagnosis.h"

namespace berth
{

/* What is found on a grid or in single samples, and not re-tuned with the base, is no cause where it is what the rig
 * file says, within its tolerance or, of what happens by chance, within its interval. `given`: with tolerances for
 * all that is the rig file's own. */
void drop_causes_as_given(block_diagnosis &result, const rig &given);

} // namespace berth

#endif
