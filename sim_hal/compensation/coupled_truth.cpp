#include "coupled_truth.h"

#include <cmath>

namespace berth
{

namespace
{

/* RK4 of an oscillation: error of (step w)^5 / 120 a step, 3e-8 here; contact is looked at this often, too. */
constexpr double radians_a_step = 0.08;
constexpr int steps_least = 16;

plant without_robot_and_sensor(const rig &rig)
{
    plant plant(rig);
    plant.has_transfer_behaviour = false;
    plant.robot_lag_s = 0.0;
    plant.sensor_lag_s = 0.0;
    plant.filter_order = 0;
    return plant;
}

} // namespace

coupled_truth::coupled_truth(const rig &rig)
    : plant_(without_robot_and_sensor(rig)), manipulator_(rig.firmware.manipulator),
      period_s_(config_period_s(&rig.firmware)), grip_release_s_(rig.run.grip_release_s)
{
    const double lightest_kg = 1.0 / (1.0 / plant_.mass_kg + 1.0 / manipulator_.mass_kg);
    const double fastest = std::sqrt((plant_.sensor_stiffness_N_per_m + plant_.stiffness_N_per_m) / lightest_kg);
    const double damping = plant_.sensor_damping_N_s_per_m / lightest_kg;
    steps_ =
        std::max(steps_least, static_cast<int>(std::ceil(period_s_ * std::max(fastest, damping) / radians_a_step)));
    step_s_ = period_s_ / steps_;
    find_tick();
}

/* Column by column, from what the steps make of a unit. */
void coupled_truth::find_tick()
{
    if (plant_.one_sided) {
        return;
    }
    tick_.setZero();
    for (Eigen::Index column = tick_.cols() - 1; column >= 0; column--) {
        Eigen::Matrix<double, tick_map::ColsAtCompileTime, 1> in = decltype(in)::Unit(column);
        arm_ = in.head<2>();
        hardware_ = in.segment<plant_state_count>(2);
        const operator_command command{in(tick_.cols() - 4), in(tick_.cols() - 3), in(tick_.cols() - 2), {}};
        step_through(command);
        tick_.col(column) << arm_, hardware_;
        if (column < tick_.cols() - 1) {
            tick_.col(column) -= tick_.col(tick_.cols() - 1);
        }
    }
}

void coupled_truth::let_go()
{
    const Eigen::Vector2d arm = arm_;
    const plant_state hardware = hardware_;
    plant_.sensor_stiffness_N_per_m = 0.0;
    plant_.sensor_damping_N_s_per_m = 0.0;
    find_tick();
    arm_ = arm;
    hardware_ = hardware;
    grip_release_s_ = never;
}

void coupled_truth::start(double position_m, double velocity_m_per_s, double time_s)
{
    time_s_ = time_s;
    arm_ << position_m, velocity_m_per_s;
    hardware_ = plant_.at_rest<plant_state>(position_m);
    hardware_(object_velocity) = velocity_m_per_s;
}

coupled_truth::rates coupled_truth::rates_at(const Eigen::Vector2d &arm, const plant_state &hardware,
                                             const operator_command &command) const
{
    const reference_line line{arm(0), arm(1)};
    const double force_N = manipulator_.stiffness_N_per_m * (command.position_m - arm(0)) +
                           manipulator_.damping_N_s_per_m * (command.velocity_m_per_s - arm(1)) + command.force_N -
                           plant_.spring_force_N(hardware, line);
    return {{arm(1), force_N / manipulator_.mass_kg}, plant_.derivative(hardware, line)};
}

void coupled_truth::step(const operator_command &command)
{
    const double h = step_s_;
    const auto at = [&](const rates &k, double share) {
        return rates_at(arm_ + share * h * k.arm, hardware_ + share * h * k.hardware, command);
    };
    const rates k1 = rates_at(arm_, hardware_, command);
    const rates k2 = at(k1, 0.5);
    const rates k3 = at(k2, 0.5);
    const rates k4 = at(k3, 1.0);
    arm_ += h / 6.0 * (k1.arm + 2.0 * k2.arm + 2.0 * k3.arm + k4.arm);
    hardware_ += h / 6.0 * (k1.hardware + 2.0 * k2.hardware + 2.0 * k3.hardware + k4.hardware);
}

void coupled_truth::advance(const operator_command &command)
{
    if (time_s_ + 0.5 * period_s_ >= grip_release_s_) { /* the nearest tick, however the sum of periods is rounded */
        let_go();
    }
    time_s_ += period_s_;
    if (plant_.one_sided) {
        step_through(command);
        return;
    }
    Eigen::Matrix<double, tick_map::ColsAtCompileTime, 1> in;
    in << arm_, hardware_, command.position_m, command.velocity_m_per_s, command.force_N, 1.0;
    const Eigen::Matrix<double, tick_map::RowsAtCompileTime, 1> out = tick_ * in;
    arm_ = out.head<2>();
    hardware_ = out.tail<plant_state_count>();
}

void coupled_truth::step_through(const operator_command &command)
{
    for (int i = 0; i < steps_; i++) {
        step(command);
    }
}

} // namespace berth
