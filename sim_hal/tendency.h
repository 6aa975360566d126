/* Which way a loop goes, where that is more than its uncertainty. */
#ifndef SIM_HAL_TENDENCY_H
#define SIM_HAL_TENDENCY_H

#include "motion.h"
#include "prediction.h"

namespace berth
{

enum class tendency { unknown, decays, grows };

tendency tendency_of(const growth_prediction &prediction);
tendency held_tendency_of(const growth_prediction &prediction); /* of a tool that stays in contact */

/* What an operator moves tells nothing of what the loop does by itself. */
tendency tendency_of(const motion_evidence &motion);

} // namespace berth

#endif
