/* What to measure by itself where no excitation of the loop tells two causes apart. */
#ifndef SIM_HAL_DIAGNOSIS_CALIBRATION_H
#define SIM_HAL_DIAGNOSIS_CALIBRATION_H

#include <string>

#include "../effects/effect.h"

namespace berth
{

/* One sentence. nullptr: the re-tuned rig itself. */
std::string calibration_for(const effect *a, const effect *b);

} // namespace berth

#endif
