#include "period_map.h"

#include <set>

#include "../../hal/rig/rig_file.h"
#include "../solver/exponential.h"
#include "../solver/generator.h"

namespace berth {

namespace {

void require_linear(const rig &rig)
{
    if (rig.object.kind == object_kind::contact) {
        throw input_error("object.kind: one-sided contact has no eigenvalues; look at a gripped object of the same "
                          "stiffness, or at the growth that `berth run` measures");
    }
    if (rig.robot.clock == robot_clock::free) {
        throw input_error("robot.clock: with a free clock the loop changes from period to period and has no "
                          "eigenvalues; use \"locked\"");
    }
}

std::vector<Eigen::Index> states_in_use(const plant &plant)
{
    std::vector<Eigen::Index> states{object_position, object_velocity};
    if (plant.filter_order >= 1) {
        states.push_back(filter_output);
    }
    if (plant.filter_order >= 2) {
        states.push_back(filter_rate);
    }
    if (plant.has_transfer_behaviour) {
        states.insert(states.end(), {robot_position, robot_velocity});
    }
    return states;
}

} // namespace

period_map::period_map(const rig &rig)
    : plant_(rig), firmware_(rig.firmware), period_ns_(config_period_ns(&rig.firmware)),
      period_s_(config_period_s(&rig.firmware)), holds_(rig.robot.interpolation == interpolation::hold)
{
    require_linear(rig);
    manipulator_start(&manipulator_, &firmware_);
    inverse_filter_start(&filter_, &firmware_);

    const std::int64_t dead_time_ns = ns_from_ms(rig.robot.dead_time_ms);
    whole_dead_periods_ = dead_time_ns / period_ns_;
    knot_ns_ = dead_time_ns % period_ns_;
    /* A knot at the tick itself ends the line before it: the setpoint that this line came from is of no more use. */
    const bool starts_on_knot = knot_ns_ == 0 && !holds_;
    history_ = static_cast<Eigen::Index>(whole_dead_periods_) + (starts_on_knot ? 0 : 1);
    samples_before_knot_ = dead_time_ns == 0; /* a sample cannot know of a setpoint that is sent after it */
    sample_ns_ = ns_from_ms(rig.sensor.sample_phase_ms);
    const std::int64_t arrival_ns = sample_ns_ + ns_from_ms(rig.sensor.delay_ms);
    sample_age_ticks_ = (arrival_ns + period_ns_ - 1) / period_ns_;
    lay_out();

    const std::set<std::int64_t> instants{0, knot_ns_, sample_ns_, period_ns_};
    const Eigen::MatrixXd generator =
        make_generator(plant_, contact_mode::attached).topLeftCorner<plant_state_count + 2, plant_state_count + 2>();
    for (auto from = instants.begin(), to = std::next(from); to != instants.end(); from = to++) {
        add_part(generator, *from, *to);
    }
}

void period_map::lay_out()
{
    plant_states_ = states_in_use(plant_);
    layout_.filter = 2;
    layout_.plant = layout_.filter + (filter_.enabled ? 4 : 0);
    layout_.setpoints = layout_.plant + static_cast<Eigen::Index>(plant_states_.size());
    layout_.samples = layout_.setpoints + history_;
    layout_.count = layout_.samples + sample_age_ticks_;
}

void period_map::add_part(const Eigen::MatrixXd &generator, std::int64_t from_ns, std::int64_t to_ns)
{
    const Eigen::MatrixXd e = balanced_exponential(generator * (static_cast<double>(to_ns - from_ns) * 1e-9));
    parts_.push_back({from_ns, to_ns, e.topRows<plant_state_count>()});
}

/* `setpoints`: newest first, the one of this tick at its head. */
reference_line period_map::line_at(const Eigen::VectorXd &setpoints, std::int64_t offset_ns, bool after_knot) const
{
    const double at_knot_m = setpoints(whole_dead_periods_);
    const double before_m = setpoints(whole_dead_periods_ + 1);
    if (holds_) {
        return {after_knot ? at_knot_m : before_m, 0.0};
    }
    const double change_m = after_knot ? setpoints(whole_dead_periods_ - 1) - at_knot_m : at_knot_m - before_m;
    const double slope_m_per_s = change_m / period_s_;
    return {at_knot_m + slope_m_per_s * static_cast<double>(offset_ns - knot_ns_) * 1e-9, slope_m_per_s};
}

Eigen::VectorXd period_map::advance(const Eigen::VectorXd &state) const
{
    Eigen::VectorXd next = Eigen::VectorXd::Zero(layout_.count);

    inverse_filter filter = filter_;
    if (filter_.enabled) {
        Eigen::Map<Eigen::Vector2d>(filter.input_m) = state.segment<2>(layout_.filter);
        Eigen::Map<Eigen::Vector2d>(filter.output_m) = state.segment<2>(layout_.filter + 2);
    }
    Eigen::VectorXd setpoints = Eigen::VectorXd::Zero(whole_dead_periods_ + 2);
    setpoints(0) = inverse_filter_step(&filter, state(layout_.manipulator));
    setpoints.segment(1, history_) = state.segment(layout_.setpoints, history_);
    next.segment(layout_.setpoints, history_) = setpoints.head(history_);
    if (filter_.enabled) {
        next.segment<2>(layout_.filter) = Eigen::Map<Eigen::Vector2d>(filter.input_m);
        next.segment<2>(layout_.filter + 2) = Eigen::Map<Eigen::Vector2d>(filter.output_m);
    }

    plant_state hardware = plant_state::Zero();
    for (std::size_t i = 0; i < plant_states_.size(); i++) {
        hardware(plant_states_[i]) = state(layout_.plant + static_cast<Eigen::Index>(i));
    }
    double sample_N = 0.0;
    for (const part &piece : parts_) {
        if (piece.from_ns == sample_ns_ && samples_before_knot_) {
            sample_N = plant_.measured_force_N(hardware, line_at(setpoints, piece.from_ns, false));
        }
        if (piece.from_ns == knot_ns_ && holds_) {
            plant_.apply_reference_jump(hardware, setpoints(whole_dead_periods_) - setpoints(whole_dead_periods_ + 1));
        }
        const reference_line line = line_at(setpoints, piece.from_ns, piece.from_ns >= knot_ns_);
        if (piece.from_ns == sample_ns_ && !samples_before_knot_) {
            sample_N = plant_.measured_force_N(hardware, line);
        }
        Eigen::Matrix<double, plant_state_count + 2, 1> augmented;
        augmented << hardware, line.position_m, line.velocity_m_per_s;
        hardware = piece.transition * augmented;
    }
    for (std::size_t i = 0; i < plant_states_.size(); i++) {
        next(layout_.plant + static_cast<Eigen::Index>(i)) = hardware(plant_states_[i]);
    }

    double force_N = sample_N;
    if (sample_age_ticks_ > 0) {
        force_N = state(layout_.samples + sample_age_ticks_ - 1);
        next(layout_.samples) = sample_N;
        next.segment(layout_.samples + 1, sample_age_ticks_ - 1) =
            state.segment(layout_.samples, sample_age_ticks_ - 1);
    }
    manipulator manipulator = manipulator_;
    manipulator.config = &firmware_.manipulator;
    manipulator.position_m = state(layout_.manipulator);
    manipulator.velocity_m_per_s = state(layout_.manipulator + 1);
    const operator_command rest{};
    manipulator_step(&manipulator, &rest, force_N);
    next.segment<2>(layout_.manipulator) << manipulator.position_m, manipulator.velocity_m_per_s;
    return next;
}

Eigen::MatrixXd period_map::matrix() const
{
    Eigen::MatrixXd result(layout_.count, layout_.count);
    for (Eigen::Index i = 0; i < layout_.count; i++) {
        result.col(i) = advance(Eigen::VectorXd::Unit(layout_.count, i));
    }
    return result;
}

} // namespace berth
