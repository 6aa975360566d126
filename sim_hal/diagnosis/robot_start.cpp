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

double seen_before_it_moves_m(const record &record, const record_segment &part, const std::vector<double> &goal_m,
                              double gap_m)
{
    if (record.robot_position_m.empty()) {
        return goal_m[0];
    }
    const auto mean_while_near = [&](double centre_m, double near_m) {
        double sum_m = 0.0;
        std::size_t n = 0;
        while (n < goal_m.size() && (n == 0 || std::abs(goal_m[n] - centre_m) <= near_m)) {
            sum_m += record.robot_position_m[part.begin + n];
            n++;
        }
        return sum_m / static_cast<double>(n);
    };
    /* Wherever in the gap it begins, then where it was seen; short of the gap's ends, which noise moves. */
    const double about_m = mean_while_near(goal_m[0], 0.1 * gap_m);
    return mean_while_near(about_m, 0.9 * gap_m);
}

} // namespace berth
