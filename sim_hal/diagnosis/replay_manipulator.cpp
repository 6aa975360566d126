#include <algorithm>
#include <cmath>
#include <Eigen/Dense>

#include "../effects/active.h"
#include "../solver/exponential.h"
#include "replay.h"

namespace berth
{

namespace
{

/* (x, v) over one step with x_op, v_op and the force held; last column: a further force against it. */
using step_map = Eigen::Matrix<double, 2, 5>;

step_map make_step_map(const manipulator_config &config, double step_s)
{
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(5, 5);
    const double k = config.stiffness_N_per_m / config.mass_kg;
    const double d = config.damping_N_s_per_m / config.mass_kg;
    a(0, 1) = 1.0;
    a.row(1) << -k, -d, k, d, 1.0 / config.mass_kg;
    const Eigen::MatrixXd e = balanced_exponential(a * step_s);
    return e.topRows<2>();
}

/* Position and velocity at the start of a window, from a parabola through its first rows. */
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
    const Eigen::Vector3d c = basis.householderQr().solve(values);
    return {c(0), c(1) / period_s};
}

} // namespace

void replay_manipulator(const rig &rig, const record &record, const std::vector<record_segment> &windows,
                        std::vector<double> &position_m)
{
    const manipulator_config &config = rig.firmware.manipulator;
    auto forces = active_stages(rig, &effect::on_body, "manipulator");
    const int steps = forces.empty() ? 1 : 4;
    const double step_s = record.period_s / steps;
    const step_map map = make_step_map(config, step_s);
    position_m.assign(record.size(), 0.0);
    for (const record_segment &window : windows) {
        Eigen::Vector2d state = first_state(record.command_position_m, window, record.period_s);
        forces = active_stages(rig, &effect::on_body, "manipulator");
        for (auto &force : forces) {
            force->start({state(0), state(0), state(1), 0.0, 0.0});
        }
        for (std::size_t n = window.begin; n < window.end; n++) {
            position_m[n] = state(0);
            const double goal_m = record.operator_position_m.empty() ? 0.0 : record.operator_position_m[n];
            const double goal_m_per_s =
                record.operator_velocity_m_per_s.empty() ? 0.0 : record.operator_velocity_m_per_s[n];
            const double push_N = (record.operator_force_N.empty() ? 0.0 : record.operator_force_N[n]) -
                                  (record.force_N.empty() ? 0.0 : record.force_N[n]);
            const Eigen::Vector2d held = map.col(2) * goal_m + map.col(3) * goal_m_per_s + map.col(4) * push_N;
            for (int i = 0; i < steps; i++) {
                Eigen::Vector2d next = map.leftCols<2>() * state + held;
                double sum_N = 0.0;
                for (auto &force : forces) {
                    const double middle_m = 0.5 * (state(0) + next(0));
                    sum_N += force->force_N({middle_m, middle_m - goal_m, next(1) - map(1, 4) * sum_N,
                                             record.time_s[n] - record.time_origin_s, map(1, 4)},
                                            step_s);
                }
                state = next - map.col(4) * sum_N;
            }
        }
    }
}

} // namespace berth
