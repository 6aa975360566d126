#include "model_controller.h"

#include <algorithm>

#include "../../firmware/matrix_exponential.h"

namespace berth::rths
{

namespace
{

/* Usual sizes in the benchmark: the filter's numbers stay near 1. */
transfer_state usual_size()
{
    transfer_state size;
    size << 2e5, 1e7, 3e3, 2e-3, 5e-2;
    return size;
}

constexpr double command_size_m = 1e-3;
constexpr double position_variance_m2 = 6.25e-14 * rate_Hz;
constexpr double force_variance_N2 = 1.16e-3 * rate_Hz;

/* Of u = -k x for the least sum of (x_e / size)^2 + effort (u / command size)^2: the recursion of Riccati until it
 * stands still. */
transfer_state regulator(const transfer_matrix &transition, const transfer_state &input, double effort)
{
    constexpr int samples = 8192;
    transfer_matrix cost = transfer_matrix::Zero();
    cost(position, position) = 1.0;
    transfer_matrix sum = cost;
    transfer_state gain = transfer_state::Zero();
    for (int n = 0; n < samples; n++) {
        const transfer_state moved = sum * input;
        gain = transition.transpose() * moved / (effort + input.dot(moved));
        const transfer_matrix closed = transition - input * gain.transpose();
        sum = cost + effort * gain * gain.transpose() + closed.transpose() * sum * closed;
    }
    return gain;
}

} // namespace

model_controller::model_controller(const known_beforehand &known, const model_settings &settings)
    : nominal_(known.nominal), settings_(settings), size_(usual_size()), dynamics_(transfer_dynamics(nominal_)),
      input_(transfer_input(nominal_))
{
    /* exp of [A b b_v; 0] over a sample: the command and an acceleration of the specimen are held. */
    constexpr int with_inputs = transfer_states + 2;
    Eigen::Matrix<double, with_inputs, with_inputs> held = Eigen::Matrix<double, with_inputs, with_inputs>::Zero();
    const transfer_state unit = size_.cwiseInverse();
    held.topLeftCorner<transfer_states, transfer_states>() = unit.asDiagonal() * dynamics_ * size_.asDiagonal();
    held.block<transfer_states, 1>(0, transfer_states) = unit.cwiseProduct(input_);
    held(velocity, transfer_states + 1) = unit(velocity);
    const auto sampled = matrix_exponential<with_inputs>(held * period_s);
    transition_ = sampled.topLeftCorner<transfer_states, transfer_states>();
    from_command_ = sampled.block<transfer_states, 1>(0, transfer_states);
    from_acceleration_ = sampled.block<transfer_states, 1>(0, transfer_states + 1);
    const double relative = command_size_m / size_(position);
    gain_ = command_size_m *
            regulator(transition_, command_size_m * from_command_, relative * relative * settings.effort)
                .cwiseProduct(unit);

    covariance_(stiffness_error, stiffness_error) = settings.stiffness_spread * settings.stiffness_spread;

    const frame whole(known.all);
    from_frame_.setZero();
    from_ground_.setZero();
    from_frame_(0, 0) = 1.0;
    for (int order = 1; order < orders; order++) {
        from_frame_.row(order) = from_frame_.row(order - 1) * whole.dynamics();
        from_ground_(order, 0) = from_frame_.row(order - 1).dot(whole.ground_input());
        from_ground_(order, 1) = from_ground_(order - 1, 0);
    }
}

model_controller::target model_controller::derivatives(const controller_input &input)
{
    const double slope = (input.ground_m_per_s2 - ground_before_m_per_s2_) * rate_Hz;
    ground_before_m_per_s2_ = input.ground_m_per_s2;
    target now =
        from_frame_ * input.simulated + from_ground_.col(0) * input.ground_m_per_s2 + from_ground_.col(1) * slope;
    /* Half a sample on: the command is held for one. */
    for (int order = 0; order + 1 < orders; order++) {
        now(order) += 0.5 * period_s * now(order + 1);
    }
    return now;
}

model_controller::hardware_motion model_controller::to_move_as(const target &wanted) const
{
    const transfer_parameters &p = nominal_;
    const double stiffness = p.specimen_stiffness_N_per_m * (1.0 + state_(stiffness_error));
    const double damping = p.specimen_damping_N_s_per_m();
    /* Force and valve with their derivatives: each is what the one after it in the chain asks for. */
    Eigen::Vector4d force_N;
    for (int n = 0; n < 4; n++) {
        force_N(n) = p.specimen_mass_kg * wanted(n + 2) + damping * wanted(n + 1) + stiffness * wanted(n);
    }
    Eigen::Vector3d valve_N_per_s;
    for (int n = 0; n < 3; n++) {
        valve_N_per_s(n) = force_N(n + 1) + p.coupling_N_per_m * wanted(n + 1) + p.leakage_per_s * force_N(n);
    }
    hardware_motion motion;
    motion.state << valve_N_per_s(0), valve_N_per_s(1), force_N(0), wanted(0), wanted(1);
    const double valve_side =
        valve_N_per_s(2) + p.valve_rate_per_s * valve_N_per_s(1) + p.valve_spring_per_s2 * valve_N_per_s(0);
    motion.command_m = (valve_side / p.valve_gain + wanted(0)) / p.command_gain;
    return motion;
}

void model_controller::correct_by(int state, double innovation, double variance)
{
    const estimate column = covariance_.col(state);
    const estimate gain = column / (column(state) + variance);
    state_ += gain * innovation;
    covariance_ -= gain * column.transpose();
}

void model_controller::correct(double measured_m, double measured_N)
{
    const double position_size = size_(position);
    const double force_size = size_(force);
    correct_by(position, measured_m / position_size - state_(position),
               position_variance_m2 / (position_size * position_size));
    correct_by(force, measured_N / force_size - state_(force), force_variance_N2 / (force_size * force_size));
}

void model_controller::predict(double command_m)
{
    const double softness_per_s2 = nominal_.specimen_stiffness_N_per_m / nominal_.specimen_mass_kg * size_(position);
    const transfer_state per_error = -softness_per_s2 * from_acceleration_;
    estimate_matrix jacobian = estimate_matrix::Identity();
    jacobian.topLeftCorner<transfer_states, transfer_states>() = transition_;
    jacobian.block<transfer_states, 1>(0, position) += per_error * state_(stiffness_error);
    jacobian.block<transfer_states, 1>(0, command_error) = from_command_ * command_size_m;
    jacobian.block<transfer_states, 1>(0, stiffness_error) = per_error * state_(position);
    const transfer_state before = state_.head<transfer_states>();
    state_.head<transfer_states>() = jacobian.topLeftCorner<transfer_states, transfer_states>() * before +
                                     from_command_ * (command_m + command_size_m * state_(command_error));
    const double limit = nominal_.force_limit_N / size_(force);
    state_(force) = std::clamp(state_(force), -limit, limit);
    const estimate_matrix moved = jacobian.lazyProduct(covariance_);
    const estimate_matrix spread = moved.lazyProduct(jacobian.transpose());
    covariance_ = 0.5 * (spread + spread.transpose());
    covariance_.diagonal().head<transfer_states>().array() += settings_.state_walk * settings_.state_walk;
    const double command_walk = settings_.command_walk_m / command_size_m;
    covariance_(command_error, command_error) += command_walk * command_walk;
    covariance_(stiffness_error, stiffness_error) += settings_.stiffness_walk * settings_.stiffness_walk;
}

controller_output model_controller::step(const controller_input &input)
{
    /* The force comes a sample late; its displacement waits for it. */
    correct(measured_before_m_, input.late_N);
    predict(command_before_m_);
    measured_before_m_ = input.measured_m;
    const hardware_motion ideal = to_move_as(derivatives(input));
    const transfer_state now = size_.cwiseProduct(state_.head<transfer_states>());
    /* The filter's states are of now, the ideal ones of half a sample on. */
    const transfer_state rate = dynamics_ * now + input_ * command_before_m_;
    const double command_m = ideal.command_m - command_size_m * state_(command_error) -
                             gain_.dot(now + 0.5 * period_s * rate - ideal.state);
    command_before_m_ = converted(command_m);
    return {command_m, now(force) + settings_.force_lead_samples * period_s * rate(force)};
}

} // namespace berth::rths
