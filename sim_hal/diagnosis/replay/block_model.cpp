#include "block_model.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>

#include "../../effects/active.h"
#include "../../solver/object_steps.h"
#include "../noise/lattice_step.h"

namespace berth
{

namespace
{

/* The manipulator integrates its errors: parts start anew. Without a spring nothing brings it back, and what moves
 * it is known worse than where it is: parts are so short that each shows the mean of the force in it, as a bow that
 * stands out of the encoder's steps. On the EMPS benchmark 12 rows give the published friction within 2 %, 200
 * within 5 %. */
constexpr double window_with_spring_s = 2.0;

constexpr std::size_t parts = 10;

bool is_held_out(std::size_t part, held_out_parts held_out, const std::array<std::size_t, 2> &tenths)
{
    switch (held_out) {
    case held_out_parts::none:
        return false;
    case held_out_parts::two_tenths:
        return part == tenths[0] || part == tenths[1];
    case held_out_parts::odd:
        return part % 2 == 1;
    case held_out_parts::even:
        return part % 2 == 0;
    }
    return false;
}

} // namespace

double resolution_rms(block block)
{
    const double step = block == block::force ? 1e-7 : 1e-11;
    return step / std::sqrt(12.0);
}

bool can_replay(const record &record, block block)
{
    switch (block) {
    case block::manipulator:
        return record.has_operator() && !record.command_position_m.empty();
    case block::robot:
        return !record.command_position_m.empty() && !record.robot_position_m.empty() && !record.moves_as_measured();
    case block::force:
        /* By setpoints, if there are any: a stiff contact cannot be driven from a noisy measured position. */
        return !(record.command_position_m.empty() && record.robot_position_m.empty()) && !record.force_N.empty();
    }
    return false;
}

bool acts_in(const effect &effect, block block, const record &record, const rig &rig)
{
    const std::string_view of = effect.block();
    const bool is_contact = rig.object.kind == object_kind::contact;
    if (effect.object != object_needed::any && (effect.object == object_needed::contact) != is_contact) {
        return false;
    }
    const bool is_of_robot = of == "robot" || effect.acts_in_robot;
    switch (block) {
    case block::manipulator:
        return of == "manipulator";
    case block::robot:
        return is_of_robot;
    case block::force:
        return of == "object" || of == "sensor" || (record.robot_position_m.empty() && is_of_robot);
    }
    return false;
}

block_model::block_model(block block, const record &record, const rig &base, const sample_events &events,
                         held_out_parts held_out)
    : block_(block), record_(record), events_(events)
{
    const bool integrates = block == block::manipulator && base.firmware.manipulator.stiffness_N_per_m == 0.0;
    const auto rows_with_spring =
        std::max<std::size_t>(20, static_cast<std::size_t>(window_with_spring_s / record.period_s));
    window_length_ = integrates ? rows_that_show_acceleration(record, rows_with_spring) : rows_with_spring;
    play_m_ = std::max(value_of_effect(base, "robot.backlash_m"), 2.0 * value_of_effect(base, "robot.deadband_m"));
    rows_to_settle_ = rows_to_settle(base);
    rows_to_forget_ = rows_to_forget(base);
    divide(held_out, window_length_);
    starts_ = starts_of_windows(record, windows_);
    if (block == block::manipulator && !record.command_position_m.empty()) {
        const auto [least, largest] =
            std::minmax_element(record.command_position_m.begin(), record.command_position_m.end());
        range_m_ = *largest - *least;
    }
    rows_per_fact_ = integrates ? 0.25 * static_cast<double>(window_length_) : 1.0;
    rounding_rms_ = std::max(resolution_rms(block), lattice_step(record_.known(measured())) / std::sqrt(12.0));
}

const std::vector<double> &block_model::measured() const
{
    switch (block_) {
    case block::manipulator:
        return record_.command_position_m;
    case block::robot:
        return record_.robot_position_m;
    case block::force:
        break;
    }
    return record_.force_N;
}

/* A tenth of the record; of many segments, whole ones. */
std::size_t block_model::part_of(std::size_t row, std::size_t segment) const
{
    return record_.segments.size() >= parts ? segment % parts : row * parts / record_.size();
}

std::array<double, 10> block_model::mean_squares_of_tenths(const std::vector<double> &error) const
{
    static_assert(parts == 10);
    std::array<double, parts> sums{};
    std::array<double, parts> counts{};
    for (std::size_t i = 0; i < record_.segments.size(); i++) {
        for (std::size_t n = record_.segments[i].begin; n < record_.segments[i].end; n++) {
            if (uses_[n] != row_use::none) {
                sums[part_of(n, i)] += error[n] * error[n];
                counts[part_of(n, i)] += 1.0;
            }
        }
    }
    for (std::size_t i = 0; i < parts; i++) {
        sums[i] /= std::max(1.0, counts[i]);
    }
    return sums;
}

void block_model::hold_out(const std::array<std::size_t, 2> &tenths)
{
    tenths_ = tenths;
    found_starts_.clear(); /* they were of other windows */
    divide(held_out_parts::two_tenths, window_length_);
    starts_ = starts_of_windows(record_, windows_);
}

/* Where in its play or dead band the robot began is known as well as it was seen, and a stiff contact shows when it
 * starts to move. Rows; 0 where that takes long. */
std::size_t block_model::until_play_is_crossed(const record_segment &segment) const
{
    const std::vector<double> &x = record_.command_position_m;
    if (block_ != block::force || !(play_m_ > 0.0)) {
        return 0;
    }
    std::size_t rows = 0;
    while (segment.begin + rows < segment.end && std::abs(x[segment.begin + rows] - x[segment.begin]) <= play_m_) {
        rows++;
    }
    return rows < (segment.end - segment.begin) / 4 ? rows : 0;
}

void block_model::divide(held_out_parts held_out, std::size_t length)
{
    uses_.assign(record_.size(), row_use::none);
    windows_.clear();
    for (std::size_t i = 0; i < record_.segments.size(); i++) {
        const record_segment &segment = record_.segments[i];
        for (std::size_t n = segment.begin + rows_to_settle_[i]; n < segment.end; n++) {
            const bool is_held = is_held_out(part_of(n, i), held_out, tenths_);
            uses_[n] = is_held ? row_use::held_out : row_use::fit;
        }
        if (block_ == block::manipulator) {
            add_windows(segment, length);
        }
    }
    std::size_t guessed_end = 0;
    for (std::size_t n = 0; n < record_.size(); n++) {
        guessed_end = record_.is_filled(n) ? n + 1 + rows_to_forget_ : guessed_end;
        const bool robot_is_known = events_.robot_repeats.empty() || events_.robot_repeats[n] == 0;
        const bool force_is_known = (events_.force_repeats.empty() || events_.force_repeats[n] == 0) &&
                                    (events_.spike.empty() || events_.spike[n] == 0);
        if ((block_ == block::robot && !robot_is_known) || (block_ == block::force && !force_is_known) ||
            n < guessed_end) {
            uses_[n] = row_use::none;
        }
    }
}

void block_model::replay_motion(const rig &rig)
{
    static const std::vector<const rig_key *> robot_keys = [] {
        std::vector<const rig_key *> found;
        for (const rig_key &key : rig_keys()) {
            if (key.path.substr(0, 6) == "robot." && key.type == key_type::number) {
                found.push_back(&key);
            }
        }
        return found;
    }();
    const int steps_min = block_ == block::force ? object_steps_a_tick(rig) : 1;
    std::vector<double> made_for{static_cast<double>(rig.robot.clock), static_cast<double>(steps_min),
                                 rig.sensor.delay_ms};
    for (const rig_key *const key : robot_keys) {
        made_for.push_back(*static_cast<double *>(key->member(const_cast<berth::rig &>(rig))));
    }
    if (made_for != motion_keys_) {
        const motion_detail detail = block_ == block::force ? motion_detail::way : motion_detail::at_ticks;
        replay_robot(rig, record_, events_, detail, steps_min, motion_);
        motion_keys_ = std::move(made_for);
    }
}

void block_model::error(const rig &rig, std::vector<double> &error)
{
    error.resize(record_.size());
    switch (block_) {
    case block::manipulator:
        replay_windows(rig, error);
        return;
    case block::robot:
        replay_motion(rig);
        compare(motion_.at_tick_m, error);
        return;
    case block::force:
        replay_motion(rig);
        replay_force(rig, record_, motion_, simulated_);
        compare(simulated_, error);
        return;
    }
}

void block_model::error_beside(const rig &rig, std::vector<double> &error)
{
    if (block_ != block::manipulator || found_starts_.empty()) {
        this->error(rig, error);
        return;
    }
    replay_manipulator(rig, record_, windows_, found_starts_, simulated_);
    error.resize(record_.size());
    compare(simulated_, error);
    remove_followed(error, all_windows());
}

/* Measured less simulated. */
void block_model::compare(const std::vector<double> &simulated, std::vector<double> &error) const
{
    const std::vector<double> &truth = measured();
    for (std::size_t n = 0; n < truth.size(); n++) {
        error[n] = uses_[n] == row_use::none ? 0.0 : truth[n] - simulated[n];
    }
}

void block_model::respond_to_force(const rig &rig, std::vector<double> &force_N) const
{
    if (block_ == block::manipulator) {
        move_manipulator(rig, force_N);
        remove_starts(rig, force_N);
    } else if (block_ == block::force) {
        pass_sensor(rig, force_N);
    }
}

/* Low-pass and delay, to the precision that a regression needs. */
void block_model::pass_sensor(const rig &rig, std::vector<double> &force_N) const
{
    const double h = record_.period_s;
    const double w = 6.28318530717958647692 * rig.sensor.low_pass_frequency_Hz;
    const double lag_s = (rig.sensor.low_pass_order == 2   ? 2.0 * rig.sensor.low_pass_damping_ratio / w
                          : rig.sensor.low_pass_order == 1 ? 1.0 / w
                                                           : 0.0) *
                         0.5;
    const double keep = lag_s > 0.0 ? std::exp(-h / lag_s) : 0.0;
    const double late = 1e-3 * rig.sensor.delay_ms / h;
    const auto whole = static_cast<std::size_t>(late);
    const double rest = late - static_cast<double>(whole);
    for (const record_segment &part : record_.segments) {
        double first = force_N[part.begin];
        double second = first;
        std::vector<double> passed;
        for (std::size_t n = part.begin; n < part.end; n++) { /* two lags of half the low-pass's own */
            first = force_N[n] + (first - force_N[n]) * keep;
            second = first + (second - first) * keep;
            passed.push_back(second);
        }
        for (std::size_t n = part.begin; n < part.end; n++) {
            const std::size_t at = n - part.begin;
            const double newer = passed[at >= whole ? at - whole : 0];
            const double older = passed[at >= whole + 1 ? at - whole - 1 : 0];
            force_N[n] = (1.0 - rest) * newer + rest * older;
        }
    }
}

void block_model::move_manipulator(const rig &rig, std::vector<double> &force_N) const
{
    const manipulator_config &config = rig.firmware.manipulator;
    const double h = record_.period_s;
    for (const record_segment &window : windows_) {
        double position_m = 0.0;
        double velocity_m_per_s = 0.0;
        for (std::size_t n = window.begin; n < window.end; n++) {
            const double push_N = force_N[n];
            force_N[n] = position_m;
            velocity_m_per_s +=
                h * (push_N - config.stiffness_N_per_m * position_m - config.damping_N_s_per_m * velocity_m_per_s) /
                config.mass_kg;
            position_m += h * velocity_m_per_s;
        }
    }
}

} // namespace berth
