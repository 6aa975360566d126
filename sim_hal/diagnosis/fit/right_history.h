/* Effects that switch: fitted where they switched at the right moment. */
#ifndef SIM_HAL_DIAGNOSIS_FIT_RIGHT_HISTORY_H
#define SIM_HAL_DIAGNOSIS_FIT_RIGHT_HISTORY_H

#include "fit.h"

namespace berth
{

/* One switching at another moment spoils what follows until motion and model meet again, and there the error says
 * nothing of the other parameters: their fit is pulled away by the stretches that are worst. So it looks only at the
 * stretches that are right, as long as they are a good part of the record; with better values for these parameters,
 * and a size that is searched anew (`size_key`), more of the record is right than before, and so on. `known` becomes
 * better or stays. */
void fit_where_right(block_model &model, const noise_model &noise, std::string_view size_key, fit_result &known,
                     int replays_max);

} // namespace berth

#endif
