#include "robot.h"

#include <algorithm>
#include <cmath>

#include "../effects/active.h"

namespace berth
{

namespace
{
constexpr std::int64_t no_event = std::numeric_limits<std::int64_t>::max();
} // namespace

robot::robot(const rig &rig, std::uint32_t setpoint_id)
    : setpoint_id_(setpoint_id), holds_(rig.robot.interpolation == interpolation::hold),
      clock_is_free_(rig.robot.clock == robot_clock::free), dead_time_ns_(ns_from_ms(rig.robot.dead_time_ms)),
      clock_period_ns_(static_cast<double>(config_period_ns(&rig.firmware)) *
                       (1.0 + 1e-6 * rig.robot.clock_drift_ppm)),
      clock_phase_ns_(1e6 * rig.robot.clock_phase_ms), jitter_ns_(1e6 * rig.robot.jitter_ms),
      jump_at_ns_(event_ns(rig.run.dead_time_jump_s)),
      jumped_dead_time_ns_(dead_time_ns_ + std::llround(1e6 * rig.run.dead_time_jump_ms)),
      dead_time_drift_(1e-3 * value_of_effect(rig, "robot.dead_time_drift_ms_per_s")),
      lost_probability_(value_of_effect(rig, "robot.lost_command_probability")), random_(rig.run.seed, stream_robot),
      lost_(rig.run.seed, stream_lost_commands), path_(rig), limits_reference_(limits_reference(rig)),
      follower_(rig.robot.velocity_limit_m_per_s)
{
    period_ns_ = clock_is_free_ ? std::llround(clock_period_ns_) : config_period_ns(&rig.firmware);
    next_latch_ns_ = clock_is_free_ ? std::llround(clock_phase_ns_) : no_event;
    const std::int64_t longest_ns =
        std::max({dead_time_ns_, jumped_dead_time_ns_,
                  dead_time_ns(static_cast<std::int64_t>(1e9 * std::min(1e9, rig.run.duration_s)))});
    knots_.resize(static_cast<std::size_t>(longest_ns / period_ns_) + 8);
    line_.position_m = path_.start(rig.firmware.manipulator.initial_position_m);
    limited_line_ = line_;
    follower_.start(line_.position_m);
    find_next_event();
}

void robot::receive(const hal_frame &frame, std::int64_t arrival_ns)
{
    berth_can_setpoint_t raw;
    if (frame.id != setpoint_id_ || berth_can_setpoint_unpack(&raw, frame.data, frame.length) < 0) {
        return;
    }
    if (loses_command()) {
        if (path_.goes_on() && !clock_is_free_ && count_ < knots_.size()) {
            add_knot(path_.go_on(), frame.time_ns);
            find_next_event();
        }
        return;
    }
    const setpoint received{arrival_ns, berth_can_setpoint_position_m_decode(raw.position_m), raw.counter};
    if (clock_is_free_) {
        waiting_.push_back(received);
        return;
    }
    if (arrival_ns <= frame.time_ns + dead_time_ns(frame.time_ns)) {
        take(received, frame.time_ns);
        find_next_event();
    }
}

void robot::take_synchronous(double position_m, std::int64_t now_ns, std::int64_t interpolation_ns)
{
    period_ns_ = interpolation_ns;
    take({now_ns, position_m, 0}, now_ns);
    find_next_event();
}

/* Of a setpoint that is sent at `now_ns`. However it drifts, it stays what the robot needs to know where to go, and
 * what its queue has room for. */
std::int64_t robot::dead_time_ns(std::int64_t now_ns) const
{
    const std::int64_t told_ns = now_ns < jump_at_ns_ ? dead_time_ns_ : jumped_dead_time_ns_;
    if (dead_time_drift_ == 0.0) {
        return told_ns;
    }
    constexpr double longest_ns = 1e11;
    const double drifted_ns = static_cast<double>(told_ns) + dead_time_drift_ * static_cast<double>(now_ns);
    const auto shortest_ns = static_cast<double>(std::min(dead_time_ns_, period_ns_));
    return std::llround(std::min(std::max(drifted_ns, shortest_ns), longest_ns));
}

/* The robot's own clock ticks: it takes the newest setpoint that is there, if there is a new one. */
void robot::latch()
{
    const auto newest = std::find_if(waiting_.rbegin(), waiting_.rend(),
                                     [&](const setpoint &s) { return s.arrival_ns <= next_latch_ns_; });
    if (newest != waiting_.rend()) {
        take(*newest, next_latch_ns_);
        waiting_.erase(waiting_.begin(), newest.base());
    }
    clock_ticks_++;
    next_latch_ns_ = std::llround(clock_phase_ns_ + clock_period_ns_ * static_cast<double>(clock_ticks_));
}

/* A dead time that has become shorter: what would arrive after a newer setpoint does not arrive. */
void robot::drop_overtaken(std::int64_t end_ns)
{
    const std::size_t under_way = is_moving_ ? 1 : 0;
    while (count_ > under_way && knots_[(first_ + count_ - 1) % knots_.size()].end_ns >= end_ns) {
        count_--;
    }
}

void robot::take(const setpoint &next, std::int64_t now_ns)
{
    if (count_ == knots_.size()) {
        return; /* more setpoints than the dead time has room for: the robot's buffer is full */
    }
    setpoint_counter_ = next.counter;
    add_knot(path_.take(next.position_m), now_ns);
}

void robot::add_knot(double position_m, std::int64_t now_ns)
{
    std::int64_t end_ns = now_ns + dead_time_ns(now_ns);
    if (jitter_ns_ > 0.0) {
        end_ns += std::llround(jitter_ns_ * (2.0 * random_.uniform() - 1.0));
    }
    if (now_ns >= jump_at_ns_) {
        drop_overtaken(end_ns);
    }
    const std::int64_t begin_ns = holds_ ? end_ns : end_ns - period_ns_;
    knots_[(first_ + count_) % knots_.size()] = {std::max(begin_ns, now_ns), end_ns, position_m};
    count_++;
}

void robot::find_next_event()
{
    next_event_ns_ = next_latch_ns_;
    if (count_ > 0) {
        const knot &next = knots_[first_];
        next_event_ns_ = std::min(next_event_ns_, is_moving_ ? next.end_ns : std::max(next.begin_ns, start_ns_));
    }
}

void robot::set_out()
{
    const knot &goal = knots_[first_];
    const std::int64_t now_ns = std::max(goal.begin_ns, start_ns_);
    start_ns_ = now_ns;
    is_moving_ = true;
    line_.velocity_m_per_s = goal.end_ns > now_ns ? (goal.position_m - line_.position_m) /
                                                        (static_cast<double>(goal.end_ns - now_ns) * 1e-9)
                                                  : 0.0;
}

double robot::arrive()
{
    const knot goal = knots_[first_];
    first_ = first_ + 1 == knots_.size() ? 0 : first_ + 1;
    count_--;
    const double jump_m = is_moving_ ? 0.0 : goal.position_m - line_.position_m;
    start_ns_ = goal.end_ns;
    line_ = {goal.position_m, 0.0};
    is_moving_ = false;
    return jump_m;
}

double robot::handle_event()
{
    if (!limits_reference_) {
        return handle_reference_event();
    }
    const std::int64_t now_ns = next_event_ns();
    if (now_ns == next_event_ns_) {
        handle_reference_event();
    }
    limit_velocity(now_ns);
    return 0.0;
}

/* From now on the limited reference follows the line that the reference is on. */
void robot::limit_velocity(std::int64_t now_ns)
{
    if (now_ns > limited_from_ns_) {
        follower_.advance(static_cast<double>(now_ns - limited_from_ns_) * 1e-9);
    }
    const reference_line goal = on_line(line_, start_ns_, now_ns);
    follower_.follow(goal.position_m, goal.velocity_m_per_s);
    limited_line_ = {follower_.position_m(), follower_.velocity_m_per_s()};
    limited_from_ns_ = now_ns;
    const double left_ns = std::ceil(1e9 * follower_.left_s());
    caught_up_ns_ = left_ns < 1e17 ? now_ns + static_cast<std::int64_t>(left_ns) : no_event;
}

double robot::handle_reference_event()
{
    double jump_m = 0.0;
    if (next_event_ns_ == next_latch_ns_) {
        latch();
    } else {
        const std::int64_t now_ns = next_event_ns_;
        if (holds_ || is_moving_) {
            jump_m = arrive();
        }
        if (!holds_ && count_ > 0 && knots_[first_].begin_ns <= now_ns) {
            set_out();
        }
    }
    find_next_event();
    return jump_m;
}

} // namespace berth
