/* What a rig does not state although the answer depends on it. */
#ifndef SIM_HAL_ASSUMPTIONS_H
#define SIM_HAL_ASSUMPTIONS_H

#include <string>
#include <string_view>
#include <vector>

#include "../hal/rig/rig.h"

namespace berth
{

struct assumption {
    std::string_view key; /* of the rig file, unit included */
    std::string value;    /* as it would stand there */
};

/* Springs, dampers, sensor, low-pass, interpolation, rate and limits that nobody stated, in the order of a rig file.
 */
std::vector<assumption> assumptions_of(const rig &rig);

} // namespace berth

#endif
