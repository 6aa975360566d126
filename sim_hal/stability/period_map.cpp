#include "period_map.h"

namespace berth
{

period_map::period_map(const rig &rig)
    : hardware_(rig), firmware_(rig.firmware), compensation_(firmware_), period_s_(config_period_s(&rig.firmware))
{
    check_compensation_is_linear(rig);
    firmware_.arm.kind = ARM_NONE;
    manipulator_start(&manipulator_, &firmware_);
    inverse_filter_start(&filter_, &firmware_);
    history_ = hardware_.whole_dead_periods() + (hardware_.needs_setpoint_before() ? 1 : 0);
    lay_out();
}

void period_map::lay_out()
{
    layout_.filter = 2;
    layout_.plant = layout_.filter + (filter_.enabled ? 4 : 0);
    layout_.setpoints = layout_.plant + hardware_.state_count();
    layout_.samples = layout_.setpoints + history_;
    layout_.compensation = layout_.samples + hardware_.sample_age_ticks();
    layout_.count = layout_.compensation + compensation_.count();
}

Eigen::VectorXd period_map::advance(const Eigen::VectorXd &state) const
{
    Eigen::VectorXd next = Eigen::VectorXd::Zero(layout_.count);

    manipulator manipulator = manipulator_;
    manipulator.config = &firmware_.manipulator;
    manipulator.position_m = state(layout_.manipulator);
    manipulator.velocity_m_per_s = state(layout_.manipulator + 1);
    compensation units = compensation_.in_state(state.tail(compensation_.count()), manipulator);

    inverse_filter filter = filter_;
    if (filter_.enabled) {
        Eigen::Map<Eigen::Vector2d>(filter.input_m) = state.segment<2>(layout_.filter);
        Eigen::Map<Eigen::Vector2d>(filter.output_m) = state.segment<2>(layout_.filter + 2);
    }
    const Eigen::Index dead = hardware_.whole_dead_periods();
    Eigen::VectorXd setpoints = Eigen::VectorXd::Zero(dead + 2); /* newest first */
    setpoints(0) = inverse_filter_step(&filter, compensation_motion(&units, manipulator.position_m));
    setpoints.segment(1, history_) = state.segment(layout_.setpoints, history_);
    next.segment(layout_.setpoints, history_) = setpoints.head(history_);
    if (filter_.enabled) {
        next.segment<2>(layout_.filter) = Eigen::Map<Eigen::Vector2d>(filter.input_m);
        next.segment<2>(layout_.filter + 2) = Eigen::Map<Eigen::Vector2d>(filter.output_m);
    }

    beam_state hardware = beam_state::Zero();
    for (int i = 0; i < hardware_.state_count(); i++) {
        hardware(hardware_.state(i)) = state(layout_.plant + i);
    }
    const double sample_N =
        hardware_.advance(hardware, {dead > 0 ? setpoints(dead - 1) : 0.0, setpoints(dead), setpoints(dead + 1)});
    for (int i = 0; i < hardware_.state_count(); i++) {
        next(layout_.plant + i) = hardware(hardware_.state(i));
    }

    const Eigen::Index age = hardware_.sample_age_ticks();
    const double force_N = age > 0 ? state(layout_.samples + age - 1) : sample_N;
    if (age > 0) {
        next(layout_.samples) = sample_N;
        next.segment(layout_.samples + 1, age - 1) = state.segment(layout_.samples, age - 1);
    }
    const operator_command rest{};
    const energy_sums energy{};
    const prediction_input in{force_N, setpoints(0), 0.0};
    const double used_N = compensation_force(&units, &rest, &energy, &in, true);
    manipulator_step(&manipulator, &rest, used_N);
    next.tail(compensation_.count()) = compensation_.state_of(units);
    next.segment<2>(layout_.manipulator) << manipulator.position_m, manipulator.velocity_m_per_s;
    return next;
}

Eigen::MatrixXd period_map::matrix() const
{
    /* So small that no unit reaches its limits; a power of two leaves every digit as it is. */
    constexpr double small = 0x1p-60;
    Eigen::MatrixXd result(layout_.count, layout_.count);
    for (Eigen::Index i = 0; i < layout_.count; i++) {
        result.col(i) = advance(small * Eigen::VectorXd::Unit(layout_.count, i)) / small;
    }
    return result;
}

} // namespace berth
