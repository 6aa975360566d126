#include "manipulator_steps.h"

#include "../effects/active.h"
#include "exponential.h"

namespace berth
{

namespace
{

constexpr int steps_with_effects = 8;

Eigen::Matrix<double, 2, 5> make_map(const manipulator_config &config, double step_s)
{
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(5, 5);
    const double k = config.stiffness_N_per_m / config.mass_kg;
    const double d = config.damping_N_s_per_m / config.mass_kg;
    a(0, 1) = 1.0;
    a.row(1) << -k, -d, k, d, 1.0 / config.mass_kg;
    const Eigen::MatrixXd e = balanced_exponential(a * step_s);
    return e.topRows<2>();
}

} // namespace

manipulator_steps::manipulator_steps(const rig &rig, double period_s)
    : forces_(active_stages(rig, &effect::on_body, "manipulator")), steps_(forces_.empty() ? 1 : steps_with_effects),
      step_s_(period_s / steps_), map_(make_map(rig.firmware.manipulator, step_s_))
{
}

void manipulator_steps::start(const Eigen::Vector2d &state)
{
    state_ = state;
    for (auto &force : forces_) {
        force->start({state(0), state(0), state(1), 0.0, 0.0});
    }
}

void manipulator_steps::advance(const input &in)
{
    const Eigen::Vector2d held =
        map_.col(2) * in.operator_position_m + map_.col(3) * in.operator_velocity_m_per_s + map_.col(4) * in.push_N;
    for (int i = 0; i < steps_; i++) {
        const Eigen::Vector2d next = map_.leftCols<2>() * state_ + held;
        const double middle_m = 0.5 * (state_(0) + next(0));
        double sum_N = 0.0;
        for (auto &force : forces_) {
            sum_N += force->force_N(
                {middle_m, middle_m - in.operator_position_m, next(1) - map_(1, 4) * sum_N, in.time_s, map_(1, 4)},
                step_s_);
        }
        state_ = next - map_.col(4) * sum_N;
    }
}

} // namespace berth
