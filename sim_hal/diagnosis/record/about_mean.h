/* How far a signal moves by itself: what any replay of it has to beat. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_ABOUT_MEAN_H
#define SIM_HAL_DIAGNOSIS_RECORD_ABOUT_MEAN_H

#include <vector>

#include "../replay/block_model.h"

namespace berth
{

/* rms of the model's measured output about its mean, over the rows that are fitted, in the output's unit. */
double rms_about_mean(const block_model &model);

} // namespace berth

#endif
