#include "driven_path.h"

#include <algorithm>
#include <cmath>

#include "../../effects/active.h"
#include "robot_reference.h"
#include "robot_start.h"

namespace berth
{

namespace
{

double half_gap_m(const rig &rig)
{
    const bool is_alone = active_stages(rig, &effect::on_motion).size() == 1 && !rig.has_transfer_behaviour();
    return is_alone ? 0.5 * value_of_effect(rig, "robot.backlash_m") : 0.0;
}

/* Where a tool with play stands as a record begins. */
double held_at_first_m(const record &record, double first_m, double half_gap_m)
{
    if (half_gap_m == 0.0 || record.segments.front().stands_m) {
        return first_m;
    }
    const auto begin = record.command_position_m.begin();
    const auto end = std::find_if(begin, record.command_position_m.end(),
                                  [&](double at_m) { return std::abs(at_m - first_m) > 4.0 * half_gap_m; });
    const double seen_m = seen_before_it_moves_m(record, record.segments.front(), {begin, end}, half_gap_m);
    return std::clamp(seen_m, first_m - half_gap_m, first_m + half_gap_m);
}

} // namespace

driven_path::driven_path(const rig &rig, const record &record)
    : path_(rig), period_s_(record.period_s), holds_(rig.robot.interpolation == interpolation::hold),
      reference_m_(path_.start(stands_on_m(rig, record, record.segments.front()))), half_gap_m_(half_gap_m(rig)),
      held_m_(held_at_first_m(record, reference_m_, half_gap_m_))
{
    if (limits_reference(rig)) {
        follower_.emplace(rig.robot.velocity_limit_m_per_s);
        follower_->start(reference_m_);
    }
}

double driven_path::follow(double reference_m)
{
    if (!follower_) {
        return reference_m;
    }
    if (holds_) {
        follower_->follow(reference_m, 0.0);
    } else {
        follower_->follow(reference_m_, (reference_m - reference_m_) / period_s_);
    }
    reference_m_ = reference_m;
    double left_s = period_s_;
    while (follower_->left_s() < left_s) { /* it never catches up twice with a line */
        left_s -= follower_->left_s();
        follower_->advance(follower_->left_s());
    }
    follower_->advance(left_s);
    return follower_->position_m();
}

double driven_path::play_behind(double driven_m)
{
    if (half_gap_m_ == 0.0) {
        return driven_m;
    }
    held_m_ = std::clamp(held_m_, driven_m - half_gap_m_, driven_m + half_gap_m_);
    return held_m_;
}

bool follows_setpoints(const rig &rig)
{
    return rig.robot.velocity_limit_m_per_s == unlimited && rig.robot.acceleration_limit_m_per_s2 == unlimited &&
           value_of_effect(rig, "robot.deadband_m") == 0.0 && half_gap_m(rig) == 0.0;
}

rig that_follows_setpoints(rig made)
{
    if (half_gap_m(made) != 0.0) {
        set_number(made, "robot.backlash_m", 0.0);
    }
    set_number(made, "robot.deadband_m", 0.0);
    made.robot.velocity_limit_m_per_s = made.robot.acceleration_limit_m_per_s2 = unlimited;
    return made;
}

std::vector<double> way_lacked_m(const rig &rig, const record &record, const std::vector<std::uint8_t> &lost)
{
    driven_path without(rig, record);
    driven_path with = without;
    std::vector<double> lacked_m(record.size(), 0.0);
    for (std::size_t n = 1; n < record.size(); n++) {
        const double sent_m = record.command_position_m[n];
        lacked_m[n] = without.take(sent_m) - (lost[n] != 0 ? with.go_on() : with.take(sent_m));
    }
    return lacked_m;
}

std::vector<double> way_at_stake_m(const rig &rig, const record &record, const std::vector<std::uint8_t> &lost)
{
    driven_path path(rig, record);
    std::vector<double> at_stake_m(record.size(), 0.0);
    for (std::size_t n = 1; n < record.size(); n++) {
        driven_path without_it = path;
        const double lost_m = without_it.go_on();
        at_stake_m[n] = std::abs(path.take(record.command_position_m[n]) - lost_m);
        if (lost[n] != 0) {
            path = without_it;
        }
    }
    return at_stake_m;
}

} // namespace berth
