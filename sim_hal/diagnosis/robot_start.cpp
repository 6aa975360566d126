#include "robot_start.h"

#include <algorithm>
#include <cmath>
#include <numeric>

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

double mean_of(const std::vector<double> &values)
{
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
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
    const auto rows_near = [&](double centre_m, double near_m) {
        const auto leaves = [&](double goal_m_n) { return std::abs(goal_m_n - centre_m) > near_m; };
        const auto end = std::find_if(goal_m.begin() + 1, goal_m.end(), leaves);
        return std::vector<double>(record.robot_position_m.begin() + static_cast<std::ptrdiff_t>(part.begin),
                                   record.robot_position_m.begin() + static_cast<std::ptrdiff_t>(part.begin) +
                                       (end - goal_m.begin()));
    };
    /* Wherever in the gap it begins, then where it was seen; short of the gap's ends, which noise moves. */
    const std::vector<double> seen_m = rows_near(mean_of(rows_near(goal_m[0], 0.1 * gap_m)), 0.9 * gap_m);
    const double mean_m = mean_of(seen_m);
    double square_m2 = 0.0;
    for (const double position_m : seen_m) {
        square_m2 += std::pow(position_m - mean_m, 2);
    }
    /* Most records begin at rest on the setpoint: what is seen there but for noise is not moved by it. */
    constexpr double clearly = 4.0; /* standard deviations of the mean */
    const auto rows = static_cast<double>(seen_m.size());
    const bool is_beside =
        std::pow(mean_m - goal_m[0], 2) * rows * std::max(1.0, rows - 1.0) > clearly * clearly * square_m2;
    return is_beside ? mean_m : goal_m[0];
}

} // namespace berth
