#include "manipulator_steps.h"

#include <algorithm>
#include <cmath>

#include "../effects/active.h"
#include "../effects/force_laws.h"
#include "exponential.h"

namespace berth
{

namespace
{

/* Where dry friction may turn, see object_steps. What sticks and slides does so at an instant within a step, but
 * only now and then: of what the friction of 2 N moves, 4e-5 is left, of which 3e-4 was with 4 parts. What bends on
 * a short way may turn in any step. */
constexpr int parts_of_instants = 32;
constexpr int parts_of_ways = 4;

/* As many as are asked for, or so many that a step is a small part of an oscillation: further forces act from the
 * chord's middle, and those of a cubic spring are off by a quarter of the square of this angle. */
int steps_of(const manipulator_config &config, double period_s, int asked)
{
    constexpr double angle_rad = 0.03;
    constexpr double most = 64.0;
    const double turned_rad = period_s * std::sqrt(config.stiffness_N_per_m / config.mass_kg);
    return std::max(asked, static_cast<int>(std::ceil(std::min(turned_rad / angle_rad, most))));
}

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

manipulator_steps::manipulator_steps(const rig &rig, double period_s, int steps)
    : forces_(active_stages(rig, &effect::on_body, "manipulator")),
      friction_N_(value_of_effect(rig, "manipulator.coulomb_friction_N") +
                  value_of_effect(rig, "manipulator.stribeck_friction_N")),
      turning_way_m_(coarse_way * value_of_effect(rig, "manipulator.coulomb_presliding_m")),
      steps_(forces_.empty() ? 1 : steps_of(rig.firmware.manipulator, period_s, steps)), step_s_(period_s / steps_),
      map_(make_map(rig.firmware.manipulator, step_s_)),
      turning_parts_(turning_way_m_ == 0.0 ? parts_of_instants : parts_of_ways),
      fine_map_(make_map(rig.firmware.manipulator, step_s_ / turning_parts_))
{
}

void manipulator_steps::start(const Eigen::Vector2d &state)
{
    state_ = state;
    for (auto &force : forces_) {
        force->start({state(0), state(0), state(1), state(1), 0.0, 0.0});
    }
}

void manipulator_steps::advance(const input &in)
{
    const held over_step = held_over(map_, in);
    const held over_part = held_over(fine_map_, in);
    for (int i = 0; i < steps_; i++) {
        if (friction_N_ > 0.0 && is_divided(over_step)) {
            for (int part = 0; part < turning_parts_; part++) {
                step(fine_map_, step_s_ / turning_parts_, over_part, in);
            }
        } else {
            step(map_, step_s_, over_step, in);
        }
    }
}

manipulator_steps::held manipulator_steps::held_over(const step_map &map, const input &in)
{
    const auto made = [&](int row) {
        return map(row, 2) * in.operator_position_m + map(row, 3) * in.operator_velocity_m_per_s +
               map(row, 4) * in.push_N;
    };
    return {made(0), made(1)};
}

/* Unless it rests or goes on as it went whatever the friction does, or turns within what bends straight, and nothing
 * else is abrupt. */
bool manipulator_steps::is_divided(const held &driven) const
{
    const double free_m_per_s = map_(1, 0) * state_(0) + map_(1, 1) * state_(1) + driven.rate_m_per_s;
    const double most_m_per_s = map_(1, 4) * friction_N_;
    const double way_m = step_s_ * std::max(std::abs(state_(1)), std::abs(free_m_per_s));
    constexpr double rounded = 1e-9; /* of what friction stops in a step */
    const bool rests = turning_way_m_ == 0.0 && std::abs(state_(1)) <= rounded * most_m_per_s &&
                       std::abs(free_m_per_s) <= most_m_per_s;
    if (rests) {
        return false;
    }
    const bool may_turn = state_(1) > 0.0 ? free_m_per_s <= most_m_per_s : free_m_per_s >= -most_m_per_s;
    return (may_turn && way_m >= turning_way_m_) || any_is_abrupt(forces_, way_m);
}

void manipulator_steps::step(const step_map &map, double step_s, const held &driven, const input &in)
{
    /* By its numbers: expressions of matrices this small are not inlined. */
    const double next_m = map(0, 0) * state_(0) + map(0, 1) * state_(1) + driven.way_m;
    const double next_m_per_s = map(1, 0) * state_(0) + map(1, 1) * state_(1) + driven.rate_m_per_s;
    const double middle_m = 0.5 * (state_(0) + next_m);
    double sum_N = 0.0;
    for (auto &force : forces_) {
        sum_N += force->force_N({middle_m, middle_m - in.operator_position_m, next_m_per_s - map(1, 4) * sum_N,
                                 state_(1), in.time_s, map(1, 4)},
                                step_s);
    }
    state_(0) = next_m - map(0, 4) * sum_N;
    state_(1) = next_m_per_s - map(1, 4) * sum_N;
}

} // namespace berth
