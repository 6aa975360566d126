#include "robot_start.h"

#include <algorithm>
#include <cmath>

namespace berth
{

namespace
{

/* The robot goes towards the setpoint on which it does not stand, though the setpoint does not go that way: one that
 * stands beside its setpoint by a wrong gain or a dead band goes as the setpoint does. */
bool goes_to_its_setpoint(const record &made, const record_segment &part)
{
    const double *told_m = made.command_position_m.data();
    const double *robot_m = made.robot_position_m.data();
    const double way_m = told_m[part.begin] - robot_m[part.begin];
    constexpr double clearly = 0.15; /* of the way */
    for (std::size_t n = part.begin; n < part.end; n++) {
        if ((told_m[n] - told_m[part.begin]) / way_m > 0.3 * clearly) {
            return false;
        }
        if ((robot_m[n] - robot_m[part.begin]) / way_m > clearly) {
            return true;
        }
    }
    return false;
}

} // namespace

void find_starts_elsewhere(record &made)
{
    const std::vector<double> &told_m = made.command_position_m;
    const std::vector<double> &robot_m = made.robot_position_m;
    if (told_m.empty() || robot_m.empty()) {
        return;
    }
    const auto [least, largest] = std::minmax_element(told_m.begin(), told_m.end());
    constexpr double far = 0.05; /* of the range: what is nearer is as well described by the setpoint */
    constexpr double still = 0.002;
    for (record_segment &part : made.segments) {
        const double range_m = *largest - *least;
        const double off_m = std::abs(told_m[part.begin] - robot_m[part.begin]);
        const bool stands =
            part.begin + 1 < part.end && std::abs(robot_m[part.begin + 1] - robot_m[part.begin]) < still * range_m;
        if (off_m > far * range_m && stands && goes_to_its_setpoint(made, part)) {
            part.stands_m = robot_m[part.begin];
        }
    }
}

} // namespace berth
