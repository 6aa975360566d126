/* The parts of a parameter's range in which a loop is stable. */
#ifndef SIM_HAL_STABILITY_STABLE_INTERVALS_H
#define SIM_HAL_STABILITY_STABLE_INTERVALS_H

#include <vector>

#include "limits.h"

namespace berth
{

/* `ends` of stable intervals within the grid, by rising value. */
std::vector<stable_interval> intervals_between(const std::vector<double> &grid, bool starts_stable,
                                               std::vector<double> ends);

/* All but those of one value, such as a whole number of periods at which the force just comes in time: no rig keeps
 * to that. The one of the rig's own value stays. */
std::vector<stable_interval> without_single_values(std::vector<stable_interval> all, double own);

/* The stable parts beyond the limit that is nearest above the rig's own value. */
std::vector<stable_interval> stable_beyond(const parameter_limits &parameter);

/* The last stable interval ends where the search ended. */
bool is_open_beyond(const parameter_limits &parameter);

} // namespace berth

#endif
