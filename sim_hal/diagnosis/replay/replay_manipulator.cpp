#include <algorithm>
#include <cmath>
#include <Eigen/Core>

#include "../../solver/decompositions.h"
#include "../../solver/manipulator_steps.h"
#include "replay.h"

namespace berth
{

namespace
{

/* Farther than any manipulator: there costs stay finite. */
constexpr double far_m = 1e3;

Eigen::Vector2d first_state(const std::vector<double> &position_m, const record_segment &window, double period_s)
{
    const std::size_t count = std::min<std::size_t>(window.end - window.begin, 15);
    if (count < 3) {
        return {position_m[window.begin], 0.0};
    }
    Eigen::MatrixXd basis(static_cast<Eigen::Index>(count), 3);
    Eigen::VectorXd values(static_cast<Eigen::Index>(count));
    for (std::size_t i = 0; i < count; i++) {
        const double t = static_cast<double>(i);
        basis.row(static_cast<Eigen::Index>(i)) << 1.0, t, t * t;
        values(static_cast<Eigen::Index>(i)) = position_m[window.begin + i];
    }
    const Eigen::Vector3d c = full_rank_least_squares(basis, values);
    return {c(0), c(1) / period_s};
}

} // namespace

std::vector<Eigen::Vector2d> starts_of_windows(const record &record, const std::vector<record_segment> &windows)
{
    std::vector<Eigen::Vector2d> starts;
    starts.reserve(windows.size());
    for (const record_segment &window : windows) {
        starts.push_back(first_state(record.command_position_m, window, record.period_s));
    }
    return starts;
}

void replay_manipulator(const rig &rig, const record &record, const std::vector<record_segment> &windows,
                        const std::vector<Eigen::Vector2d> &starts, std::vector<double> &position_m)
{
    const bool moves = !record.push_within_rows_N.empty();
    const std::size_t parts = moves ? pushes_a_row : 1;
    const double part_s = record.period_s / static_cast<double>(parts);
    manipulator_steps steps(rig, part_s, moves ? 1 : steps_with_effects);
    position_m.resize(record.size());
    for (std::size_t i = 0; i < windows.size(); i++) {
        const record_segment &window = windows[i];
        steps.start(starts[i]);
        for (std::size_t n = window.begin; n < window.end; n++) {
            const double x_m = steps.state()(0);
            position_m[n] = std::abs(x_m) < far_m ? x_m : std::copysign(far_m, x_m); /* a spring that gives way */
            const double goal_m = record.operator_position_m.empty() ? 0.0 : record.operator_position_m[n];
            const double goal_m_per_s =
                record.operator_velocity_m_per_s.empty() ? 0.0 : record.operator_velocity_m_per_s[n];
            const double push_N = (record.operator_force_N.empty() ? 0.0 : record.operator_force_N[n]) -
                                  (record.force_N.empty() ? 0.0 : record.force_N[n]);
            const double time_s = record.time_s[n] - record.time_origin_s;
            for (std::size_t part = 0; part < parts; part++) {
                steps.advance({goal_m, goal_m_per_s, moves ? record.push_within_rows_N[n * parts + part] : push_N,
                               time_s + static_cast<double>(part) * part_s});
            }
        }
    }
}

} // namespace berth
