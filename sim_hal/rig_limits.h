/* How far each physical parameter of a rig may go, for every client alike. */
#ifndef SIM_HAL_RIG_LIMITS_H
#define SIM_HAL_RIG_LIMITS_H

#include <functional>
#include <string_view>
#include <vector>

#include "../hal/rig/rig.h"
#include "stability/limits.h"

namespace berth
{

/* How the loop of a rig is made linear: a tool stays in contact; at an amplitude above 0, effects of size are
 * replaced by what is equivalent there. */
linear_view linear_view_at(double amplitude_m);

/* How finely limits_of() looks. */
scan scan_at(const rig &rig, double amplitude_m);

/* Of a loop without compensation that does not change from tick to tick, nor on schedule; bounces that gain energy
 * are unstable, too. `next` gets each key before its search; may be empty. Throws input_error. */
std::vector<parameter_limits> limits_of(const rig &rig, double amplitude_m,
                                        const std::function<void(std::string_view)> &next = {});

} // namespace berth

#endif
