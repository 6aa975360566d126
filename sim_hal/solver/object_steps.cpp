#include "object_steps.h"

#include "../effects/active.h"
#include "exponential.h"
#include "generator.h"

namespace berth
{

namespace
{

/* What moves is the robot itself already, and effects are stages. */
plant object_alone(const rig &original)
{
    rig made = original;
    made.robot.transfer_frequency_Hz = unlimited;
    plant object(made);
    object.leave_out_linear_effects();
    return object;
}

object_steps::step_map make_map(const plant &original, object_steps::grip grip, double step_s)
{
    constexpr auto rows = static_cast<Eigen::Index>(object_steps::rows);
    constexpr auto columns = static_cast<Eigen::Index>(object_steps::columns);
    plant plant = original;
    if (grip == object_steps::grip::is_lost) {
        plant.is_held = false;
    }
    const bool is_free = grip == object_steps::grip::free_of_material;
    const Eigen::MatrixXd full =
        make_generator<plant_state>(plant, is_free ? contact_mode::free : contact_mode::attached);
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(columns, columns);
    a.topLeftCorner<rows, rows>() = full.topLeftCorner<rows, rows>();
    a.block<rows, 2>(0, rows) = full.block<rows, 2>(0, plant_state_count); /* u, u' */
    a(rows, rows + 1) = a(rows + 1, rows + 2) = 1.0;
    a.block<rows, 1>(0, rows + 3) = full.block<rows, 1>(0, plant_state_count + 2);
    a(object_velocity, columns - 1) = -1.0 / plant.mass_kg;
    const Eigen::MatrixXd e = balanced_exponential(a * step_s);
    object_steps::step_map map;
    for (Eigen::Index column = 0; column < columns; column++) {
        for (Eigen::Index row = 0; row < rows; row++) {
            map.column[static_cast<std::size_t>(column)][static_cast<std::size_t>(row)] = e(row, column);
        }
    }
    return map;
}

} // namespace

int object_steps_a_tick(const rig &rig)
{
    const bool is_nonlinear = rig.object.kind == object_kind::contact || rig.run.grip_release_s < never ||
                              grip_closes_s(rig) > 0.0 || value_of_effect(rig, "object.grip_force_N") > 0.0 ||
                              !active_stages(rig, &effect::on_body, "object").empty();
    const bool has_filter = !active_stages(rig, &effect::on_force).empty();
    const bool has_linear_body = value_of_effect(rig, "object.second_mass_kg") > 0.0 ||
                                 value_of_effect(rig, "object.relaxation_stiffness_N_per_m") > 0.0;
    return value_of_effect(rig, "object.impact_damping_s_per_m") > 0.0 ? stiffening_steps_a_tick
           : has_filter || has_linear_body                             ? filtered_steps_a_tick
           : is_nonlinear                                              ? fine_steps_a_tick
                                                                       : 1;
}

object_steps::object_steps(const rig &rig)
    : plant_(object_alone(rig)), grip_force_N_(value_of_effect(rig, "object.grip_force_N")),
      grip_close_s_(grip_closes_s(rig)), grip_release_s_(rig.run.grip_release_s),
      impact_damping_s_per_m_(plant_.one_sided ? value_of_effect(rig, "object.impact_damping_s_per_m") : 0.0),
      friction_N_(value_of_effect(rig, "object.coulomb_friction_N")),
      switches_(plant_.one_sided || grip_force_N_ > 0.0 || grip_release_s_ < never || grip_close_s_ > 0.0)
{
}

object_steps::step_maps object_steps::make_maps(double step_s) const
{
    step_maps made;
    const auto make = [&](grip of) { made[static_cast<std::size_t>(of)] = make_map(plant_, of, step_s); };
    make(grip::holds);
    if (plant_.one_sided) {
        make(grip::free_of_material);
    }
    if (grip_force_N_ > 0.0 || grip_release_s_ < never || grip_close_s_ > 0.0) {
        make(grip::is_lost);
    }
    return made;
}

void object_steps::start(const rig &rig, double position_m, double time_s)
{
    is_open_ = grip_close_s_ > 0.0;
    gripped_at_m_ = is_open_ ? position_m : 0.0;
    const plant_state rest = plant_.at_rest<plant_state>(position_m - gripped_at_m_);
    std::copy(rest.data(), rest.data() + rows, state_.begin());
    line_ = {position_m - gripped_at_m_, 0.0};
    forces_ = active_stages(rig, &effect::on_body, "object");
    grip_ = is_open_ ? grip::is_lost : grip::holds;
    is_released_ = false;
    further_N_ = 0.0;
    for (auto &force : forces_) {
        force->start({state_[object_position], state_[object_position], 0.0, 0.0, time_s, 0.0});
    }
}

void object_steps::jump(double to_m)
{
    if (grip_ != grip::is_lost) {
        plant_state full = full_state();
        plant_.apply_reference_jump(full, to_m - gripped_at_m_ - line_.position_m);
        std::copy(full.data(), full.data() + rows, state_.begin());
    }
    line_ = {to_m - gripped_at_m_, 0.0};
    bend_m_per_s2_ = 0.0;
}

/* Unless it goes on as it went whatever the friction does, and that does nothing else. Only the sign counts: a step
 * in the other grip, which has other maps, is none that slides. */
bool object_steps::is_divided(const step_maps &maps, double step_s, const robot_way &way) const
{
    const step_map &map = maps[static_cast<std::size_t>(grip_)];
    const double input[inputs] = {way.from_m - gripped_at_m_, way.velocity_m_per_s(step_s),
                                  way.acceleration_m_per_s2(step_s), 1.0};
    double free_m_per_s = 0.0;
    for (std::size_t column = 0; column < rows; column++) {
        free_m_per_s += map.column[column][object_velocity] * state_[column];
    }
    for (std::size_t column = 0; column < inputs; column++) {
        free_m_per_s += map.column[rows + column][object_velocity] * input[column];
    }
    const double most_m_per_s = std::abs(map.column[columns - 1][object_velocity]) * friction_N_;
    const double before_m_per_s = state_[object_velocity];
    const double way_m = step_s * std::max(std::abs(before_m_per_s), std::abs(free_m_per_s));
    const bool may_turn = before_m_per_s > 0.0 ? free_m_per_s <= most_m_per_s : free_m_per_s >= -most_m_per_s;
    return may_turn || any_is_abrupt(forces_, way_m);
}

void object_steps::advance_in_parts(const step_maps &fine, double step_s, const robot_way &way, double time_s)
{
    const int count = parts();
    for (int i = 0; i < count; i++) {
        advance(fine, step_s / count, way.part(i, count), time_s);
    }
}

/* What decides goes nearly straight over so short a step. */
void object_steps::advance_switching(const step_maps &maps, double step_s, const robot_way &way, double time_s)
{
    const body_state before = state_;
    advance(maps, step_s, way, time_s);
    const double margin_after = margin();
    if (margin_after >= 0.0) {
        return;
    }
    const body_state as_before = state_;
    const reference_line line_after = line_;
    state_ = before;
    line_ = {way.from_m - gripped_at_m_, way.velocity_m_per_s(step_s)};
    const double margin_before = std::max(0.0, margin());
    const double share = margin_before / (margin_before - margin_after);
    grip_ = next_grip();
    const bool has_forces = !forces_.empty(); /* these have been asked for this step */
    body_state switched =
        has_forces ? state_alone_after(map_of(maps, grip_)) : state_after(maps, grip_, step_s, time_s);
    if (has_forces) {
        push(map_of(maps, grip_), further_N_, switched);
    }
    for (std::size_t row = 0; row < rows; row++) {
        state_[row] = share * as_before[row] + (1.0 - share) * switched[row];
    }
    line_ = line_after;
}

bool object_steps::will_switch(const step_maps &maps, double step_s, const robot_way &way, double time_s)
{
    const body_state before = state_;
    const grip grip_before = grip_;
    begin_step(step_s, way, time_s);
    const step_map &map = map_of(maps, grip_);
    state_ = state_alone_after(map);
    push(map, further_N_, state_);
    end_step(step_s, way);
    const bool switches = margin() < 0.0;
    state_ = before;
    grip_ = grip_before;
    return switches;
}

double object_steps::further_force_N(const step_map &map, const body_state &alone, bool is_crossley, double time_s,
                                     double step_s)
{
    const auto &push = map.column[columns - 1];
    const double middle_m = 0.5 * (state_[object_position] + alone[object_position]);
    double sum_N = 0.0;
    if (is_crossley) {
        /* The force of the step's middle, which it moves itself. */
        constexpr int rounds = 3;
        for (int round = 0; round < rounds; round++) {
            const double depth = middle_m + 0.5 * push[object_position] * sum_N - plant_.surface_m;
            const double rate =
                0.5 * (state_[object_velocity] + alone[object_velocity] + push[object_velocity] * sum_N);
            sum_N = std::max(0.0, plant_.stiffness_N_per_m * depth * (1.0 + impact_damping_s_per_m_ * rate));
        }
    }
    for (auto &force : forces_) {
        sum_N += force->force_N({middle_m, middle_m, alone[object_velocity] + push[object_velocity] * sum_N,
                                 state_[object_velocity], time_s, -push[object_velocity]},
                                step_s);
    }
    return sum_N;
}

} // namespace berth
