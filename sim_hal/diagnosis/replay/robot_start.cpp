#include "robot_start.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Core>

#include "../noise/noise.h"

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

struct stand {
    double mean_m;
    double rms_m; /* about it */
};

stand stand_of(const std::vector<double> &all_m, std::size_t begin, std::size_t rows)
{
    const Eigen::Map<const Eigen::ArrayXd> some_m(all_m.data() + begin, static_cast<Eigen::Index>(rows));
    const double mean_m = some_m.mean();
    return {mean_m, std::sqrt((some_m - mean_m).square().mean())};
}

} // namespace

robot_at_rest::robot_at_rest(const record &record, double on_the_way_s)
    : record_(record), on_the_way_s_(on_the_way_s)
{
    const auto [least, largest] =
        std::minmax_element(record.command_position_m.begin(), record.command_position_m.end());
    range_m_ = *largest - *least;
    standing_m_ = rms_of_noise_and_rounding(record.robot_position_m);
}

bool robot_at_rest::begins(const record_segment &part) const
{
    constexpr double soon_s = 0.01;
    if (part.stands_m) {
        return true;
    }
    const double on_the_way_s = std::max(soon_s, on_the_way_s_);
    if (static_cast<double>(part.end - part.begin) * record_.period_s < on_the_way_s) {
        return false; /* too short to show what comes */
    }
    const std::vector<double> &told_m = record_.command_position_m;
    const auto rows_of = [&](double time_s) {
        const auto rows = static_cast<std::size_t>(std::ceil(time_s / record_.period_s));
        return std::min(std::max<std::size_t>(2, rows), part.end - part.begin - 1);
    };
    const double off_m = record_.robot_position_m[part.begin] - told_m[part.begin];
    const double way_m = told_m[part.begin + rows_of(soon_s)] - told_m[part.begin];
    if (!(std::abs(off_m) < 0.02 * range_m_ && std::abs(way_m) < 0.002 * range_m_)) {
        return false;
    }
    const stand robot = stand_of(record_.robot_position_m, part.begin, rows_of(on_the_way_s) + 1);
    const stand told = stand_of(told_m, part.begin, rows_of(2.0 * on_the_way_s) + 1);
    /* At a turning point it may seem to stand, beside its setpoint. */
    constexpr double hardly_more = 2.0;
    const bool is_there = std::abs(robot.mean_m - told_m[part.begin]) <= hardly_more * standing_m_;
    return robot.rms_m <= hardly_more * standing_m_ && (is_there || told.rms_m <= hardly_more * standing_m_);
}

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
    /* Wherever in the gap it begins, then where it was seen; short of the gap's ends, which noise moves, and at
     * which it may stand. */
    std::vector<double> seen_m = rows_near(goal_m[0], 0.1 * gap_m);
    const double first_m = mean_of(seen_m);
    if (std::abs(goal_m[0] - first_m) < 0.9 * gap_m) {
        seen_m = rows_near(first_m, 0.9 * gap_m);
    }
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
