#include "hardware_period.h"

#include <algorithm>

#include "../../hal/rig/rig_file.h"

namespace berth
{

namespace
{

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

Eigen::Index first_state(int pair)
{
    return 2 * static_cast<Eigen::Index>(pair);
}

pair_vector pair_of(const plant_state &state, int pair)
{
    const Eigen::Index first = first_state(pair);
    return pair_vector{state(first), state(first + 1)};
}

} // namespace

hardware_period::hardware_period(const rig &rig)
    : plant_(rig), period_ns_(config_period_ns(&rig.firmware)),
      holds_(rig.robot.interpolation == interpolation::hold)
{
    require_linear(rig);
    const std::int64_t dead_time_ns = ns_from_ms(rig.robot.dead_time_ms);
    whole_dead_periods_ = static_cast<int>(dead_time_ns / period_ns_);
    knot_ns_ = dead_time_ns % period_ns_;
    samples_before_knot_ = dead_time_ns == 0; /* a sample cannot know of a setpoint that is sent after it */
    sample_ns_ = ns_from_ms(rig.sensor.sample_phase_ms);
    const std::int64_t arrival_ns = sample_ns_ + ns_from_ms(rig.sensor.delay_ms);
    sample_age_ticks_ = static_cast<int>((arrival_ns + period_ns_ - 1) / period_ns_);

    find_states_in_use();
    std::array<std::int64_t, 4> instants{0, knot_ns_, sample_ns_, period_ns_};
    std::sort(instants.begin(), instants.end());
    for (std::size_t i = 1; i < instants.size(); i++) {
        if (instants[i] > instants[i - 1]) {
            add_part(instants[i - 1], instants[i]);
        }
    }
}

void hardware_period::find_states_in_use()
{
    const auto use = [&](int first, int count) {
        for (int i = 0; i < count; i++) {
            states_[static_cast<std::size_t>(state_count_++)] = first + i;
        }
    };
    const auto link = [&](int pair) { pairs_[static_cast<std::size_t>(link_count_++)] = pair; };
    if (plant_.filter_order > 0) {
        link(filter_pair);
    }
    use(object_position, 2);
    link(object_pair);
    if (plant_.has_transfer_behaviour) {
        use(robot_position, 2);
        link(robot_pair);
    }
    use(filter_output, static_cast<int>(plant_.filter_order));
}

void hardware_period::add_part(std::int64_t from_ns, std::int64_t to_ns)
{
    part &made = parts_[static_cast<std::size_t>(part_count_++)];
    made.from_ns = from_ns;
    const double duration_s = static_cast<double>(to_ns - from_ns) * 1e-9;
    switch (link_count_) {
    case 1:
        return set_change<2>(made, duration_s);
    case 2:
        return set_change<3>(made, duration_s);
    default:
        return set_change<4>(made, duration_s);
    }
}

/* exp of the plant's equations, asked for unit vectors so that they stand in one place only, in natural units, so
 * that no digits are lost between metres and newtons. */
template <int count>
void hardware_period::set_change(part &made, double duration_s) const
{
    constexpr int inputs = count - 1;
    const plant_state zero = plant_state::Zero();
    const plant_state natural = plant_.natural_scales();
    std::array<pair_vector, count> scales;
    for (int i = 0; i < inputs; i++) {
        scales[static_cast<std::size_t>(i)] = pair_of(natural, link_pair(i));
    }
    scales[inputs] = pair_vector{1.0, 1.0 / duration_s}; /* the slope counts in metres per part */

    block_triangular<count> generator;
    const auto set_column = [&](int column, int side, const plant_state &rate) {
        for (int row = 0; row <= std::min(column, inputs - 1); row++) {
            generator.at(row, column).columns[static_cast<std::size_t>(side)] = pair_of(rate, link_pair(row));
        }
    };
    for (int i = 0; i < inputs; i++) {
        set_column(i, 0, plant_.derivative(plant_state::Unit(first_state(link_pair(i))), {}));
        set_column(i, 1, plant_.derivative(plant_state::Unit(first_state(link_pair(i)) + 1), {}));
    }
    set_column(inputs, 0, plant_.derivative(zero, {1.0, 0.0}));
    set_column(inputs, 1, plant_.derivative(zero, {0.0, 1.0}));
    generator.at(inputs, inputs) = {pair_vector{0.0, 0.0}, pair_vector{1.0, 0.0}}; /* u grows by its slope */

    std::array<pair_vector, count> inverse_scales;
    for (std::size_t i = 0; i < count; i++) {
        inverse_scales[i] = 1.0 / scales[i];
    }
    generator.for_each([&](int row, int column) {
        block &entry = generator.at(row, column);
        const pair_vector from = scales[static_cast<std::size_t>(column)] * duration_s;
        const pair_vector to = inverse_scales[static_cast<std::size_t>(row)];
        entry.columns[0] *= to * from[0];
        entry.columns[1] *= to * from[1];
    });
    const block_triangular<count> change = exponential_minus_identity(generator);
    change.for_each([&](int row, int column) {
        block &entry = made.change.at(row, column);
        const pair_vector from = inverse_scales[static_cast<std::size_t>(column)];
        const pair_vector to = scales[static_cast<std::size_t>(row)];
        entry.columns[0] = change.at(row, column).columns[0] * to * from[0];
        entry.columns[1] = change.at(row, column).columns[1] * to * from[1];
    });
}

reference_line hardware_period::line_at(const setpoint_window &setpoints, std::int64_t offset_ns,
                                        bool after_knot) const
{
    if (holds_) {
        return {after_knot ? setpoints.now_m : setpoints.before_m, 0.0};
    }
    const double change_m = after_knot ? setpoints.next_m - setpoints.now_m : setpoints.now_m - setpoints.before_m;
    const double slope_m_per_s = change_m / (static_cast<double>(period_ns_) * 1e-9);
    return {setpoints.now_m + slope_m_per_s * static_cast<double>(offset_ns - knot_ns_) * 1e-9, slope_m_per_s};
}

double hardware_period::advance(plant_state &state, const setpoint_window &setpoints) const
{
    double sample_N = 0.0;
    for (int i = 0; i < part_count_; i++) {
        const part &piece = parts_[static_cast<std::size_t>(i)];
        if (piece.from_ns == sample_ns_ && samples_before_knot_) {
            sample_N = plant_.measured_force_N(state, line_at(setpoints, piece.from_ns, false));
        }
        if (piece.from_ns == knot_ns_ && holds_) {
            plant_.apply_reference_jump(state, setpoints.now_m - setpoints.before_m);
        }
        const reference_line line = line_at(setpoints, piece.from_ns, piece.from_ns >= knot_ns_);
        if (piece.from_ns == sample_ns_ && !samples_before_knot_) {
            sample_N = plant_.measured_force_N(state, line);
        }
        const pair_vector inputs{line.position_m, line.velocity_m_per_s};
        for (int row = 0; row < link_count_; row++) { /* those behind it have not moved yet */
            pair_vector change = piece.change.at(row, link_count_) * inputs;
            for (int column = row; column < link_count_; column++) {
                change += piece.change.at(row, column) * pair_of(state, link_pair(column));
            }
            state(first_state(link_pair(row))) += change[0];
            state(first_state(link_pair(row)) + 1) += change[1];
        }
    }
    return sample_N;
}

block hardware_period::link_change(int link) const
{
    block product = parts_[0].change.at(link, link);
    for (int i = 1; i < part_count_; i++) { /* (1 + b)(1 + a) - 1 */
        const block &after = parts_[static_cast<std::size_t>(i)].change.at(link, link);
        const block before = product;
        for (std::size_t c = 0; c < 2; c++) {
            product.columns[c] += after.columns[c] + after * before.columns[c];
        }
    }
    return product;
}

} // namespace berth
