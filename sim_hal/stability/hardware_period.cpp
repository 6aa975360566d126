#include "hardware_period.h"

#include <algorithm>

#include "../../firmware/matrix_exponential.h"
#include "../../hal/rig/rig_file.h"
#include "../solver/generator.h"

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

/* exp of the generator with its states in natural units, so that no digits are lost between metres and newtons:
 * `places` are the rows and columns in use. */
template <int size>
void exponential_of_part(const plant_generator &generator, const std::array<int, 8> &places,
                         const plant_state &scales, double duration_s,
                         Eigen::Matrix<double, plant_state_count, plant_state_count + 2> &transition)
{
    const auto scale = [&](int place) { return place < plant_state_count ? scales(place) : 1.0; };
    Eigen::Matrix<double, size, size> scaled;
    for (int i = 0; i < size; i++) {
        for (int j = 0; j < size; j++) {
            scaled(i, j) = generator(places[i], places[j]) * duration_s * (scale(places[j]) / scale(places[i]));
        }
    }
    /* The slope counts in metres per part, for the same reason. */
    scaled.col(size - 1) /= duration_s;
    const Eigen::Matrix<double, size, size> e = matrix_exponential<size>(scaled);
    for (int i = 0; i < size - 2; i++) {
        for (int j = 0; j < size - 1; j++) {
            transition(places[i], places[j]) = e(i, j) * (scale(places[i]) / scale(places[j]));
        }
        transition(places[i], plant_state_count + 1) = e(i, size - 1) * scale(places[i]) * duration_s;
    }
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
    use(object_position, 2);
    if (plant_.has_transfer_behaviour) {
        use(robot_position, 2);
    }
    use(filter_output, static_cast<int>(plant_.filter_order));
}

void hardware_period::add_part(std::int64_t from_ns, std::int64_t to_ns)
{
    part &made = parts_[static_cast<std::size_t>(part_count_++)];
    made.from_ns = from_ns;
    made.transition.setZero();
    std::array<int, 8> places{};
    std::copy(states_.begin(), states_.begin() + state_count_, places.begin());
    places[static_cast<std::size_t>(state_count_)] = plant_state_count;
    places[static_cast<std::size_t>(state_count_) + 1] = plant_state_count + 1;

    const plant_generator generator = make_generator(plant_, contact_mode::attached);
    const plant_state scales = plant_.natural_scales();
    const double duration_s = static_cast<double>(to_ns - from_ns) * 1e-9;
    switch (state_count_) {
    case 2:
        return exponential_of_part<4>(generator, places, scales, duration_s, made.transition);
    case 3:
        return exponential_of_part<5>(generator, places, scales, duration_s, made.transition);
    case 4:
        return exponential_of_part<6>(generator, places, scales, duration_s, made.transition);
    case 5:
        return exponential_of_part<7>(generator, places, scales, duration_s, made.transition);
    default:
        return exponential_of_part<8>(generator, places, scales, duration_s, made.transition);
    }
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
        Eigen::Matrix<double, plant_state_count + 2, 1> augmented;
        augmented << state, line.position_m, line.velocity_m_per_s;
        state = piece.transition * augmented;
    }
    return sample_N;
}

Eigen::Matrix<double, plant_state_count, plant_state_count> hardware_period::transition() const
{
    Eigen::Matrix<double, plant_state_count, plant_state_count> product =
        parts_[0].transition.leftCols<plant_state_count>();
    for (int i = 1; i < part_count_; i++) {
        product = (parts_[static_cast<std::size_t>(i)].transition.leftCols<plant_state_count>() * product).eval();
    }
    return product;
}

} // namespace berth
