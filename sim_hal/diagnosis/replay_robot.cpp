#include <algorithm>
#include <cmath>

#include "../effects/robot_drive.h"
#include "../effects/setpoint_path.h"
#include "../effects/velocity_follower.h"
#include "../solver/object_steps.h"
#include "replay.h"
#include "robot_start.h"

namespace berth
{

namespace
{

/* The reference passes position_m at time_s, counted from the start of the segment; straight lines between. */
struct knot {
    double time_s;
    double position_m;
};

/* The setpoint that a robot with a dead band stands on; without, the first one. */
double start_in_deadband_m(const rig &rig, const record &record, const record_segment &part)
{
    const double *wanted_m = record.command_position_m.data();
    const double deadband_m = value_of_effect(rig, "robot.deadband_m");
    if (deadband_m == 0.0) {
        return wanted_m[part.begin];
    }
    std::size_t end = part.begin + 1;
    while (end < part.end && std::abs(wanted_m[end] - wanted_m[part.begin]) <= 2.0 * deadband_m) {
        end++;
    }
    return seen_before_it_moves_m(record, part, {wanted_m + part.begin, wanted_m + end}, deadband_m);
}

/* Setpoints of one segment as the robot takes them; of a lost one the place before it. */
std::vector<double> taken_setpoints(const rig &rig, const record &record, const record_segment &part,
                                    const sample_events &events)
{
    setpoint_path path(rig);
    std::vector<double> taken(part.end - part.begin);
    double newest_m = path.start(part.stands_m.value_or(start_in_deadband_m(rig, record, part)));
    for (std::size_t n = 0; n < taken.size(); n++) {
        if (events.lost_command.empty() || events.lost_command[part.begin + n] == 0) {
            newest_m = path.take(record.command_position_m[part.begin + n]);
        }
        taken[n] = newest_m;
    }
    return taken;
}

/* Of a period: a jump of the reference is at the end of a step as short as this, in which the object sees it; at a
 * tick the robot has jumped when it is asked where it is. */
constexpr double jump_lasts = 1e-5;

/* A line that ends at a knot lasts one period; before it the reference stands. */
void add_knot(std::vector<knot> &knots, double time_s, double position_m, double period_s, bool holds)
{
    if (holds) { /* whichever way the step's ends are rounded */
        knots.push_back({time_s - 0.5 * jump_lasts * period_s, position_m});
        return;
    }
    const double begin_s = time_s - period_s;
    if (!knots.empty() && begin_s > knots.back().time_s + 1e-9 * period_s) {
        knots.push_back({begin_s, knots.back().position_m});
    }
    knots.push_back({time_s, position_m});
}

/* The reference through these knots as a limit of its velocity leaves it: lines between knots, whether that one
 * jumps at its own or not. */
std::vector<knot> with_limited_velocity(const std::vector<knot> &knots, bool holds, double velocity_max_m_per_s)
{
    std::vector<knot> limited;
    limited.reserve(2 * knots.size());
    velocity_follower follower(velocity_max_m_per_s);
    const auto go_on = [&](double time_s, double duration_s) {
        double left_s = duration_s;
        while (follower.left_s() < left_s) { /* it may be left behind again at once, but never catches up twice */
            const double part_s = follower.left_s();
            follower.advance(part_s);
            left_s -= part_s;
            limited.push_back({time_s + duration_s - left_s, follower.position_m()});
        }
        if (left_s < unlimited) {
            follower.advance(left_s);
            limited.push_back({time_s + duration_s, follower.position_m()});
        }
    };
    follower.start(knots.front().position_m);
    limited.push_back(knots.front());
    for (std::size_t i = 0; i < knots.size(); i++) {
        const bool is_last = i + 1 == knots.size();
        const double duration_s = is_last ? unlimited : knots[i + 1].time_s - knots[i].time_s;
        if (duration_s <= 0.0) {
            continue;
        }
        const double rise_m = is_last || holds ? 0.0 : knots[i + 1].position_m - knots[i].position_m;
        follower.follow(knots[i].position_m, rise_m / duration_s);
        go_on(knots[i].time_s, duration_s);
    }
    return limited;
}

std::vector<knot> reference_knots(const rig &rig, const record &record, const record_segment &part,
                                  const sample_events &events)
{
    const std::vector<double> taken = taken_setpoints(rig, record, part, events);
    const double period_s = record.period_s;
    const double dead_time_s = 1e-3 * rig.robot.dead_time_ms + 1e-9 * static_cast<double>(sync_wait_ns(rig));
    const double drift = 1e-3 * value_of_effect(rig, "robot.dead_time_drift_ms_per_s");
    const bool holds = rig.robot.interpolation == interpolation::hold;
    const auto is_lost = [&](std::size_t n) {
        return !events.lost_command.empty() && events.lost_command[part.begin + n] != 0;
    };
    std::vector<knot> knots;
    knots.reserve(taken.size() + 16);
    if (part.stands_m) {
        knots.push_back({-period_s, setpoint_path(rig).start(*part.stands_m)});
    }
    if (rig.robot.clock == robot_clock::locked) {
        for (std::size_t n = 0; n < taken.size(); n++) {
            const double sent_s = period_s * static_cast<double>(n);
            if (!is_lost(n)) {
                const double since_start_s = record.time_s[part.begin + n] - record.time_origin_s;
                add_knot(knots, sent_s + dead_time_s + drift * since_start_s, taken[n], period_s, holds);
            }
        }
        return knots;
    }
    const double clock_period_s = period_s * (1.0 + 1e-6 * rig.robot.clock_drift_ppm);
    const double arrival_s = setpoint_arrival_s(rig);
    /* The first of its ticks in this segment. */
    const double begin_s = record.time_s[part.begin] - record.time_origin_s;
    const double phase_s = std::fmod(1e-3 * rig.robot.clock_phase_ms, period_s);
    double latch_s = phase_s + clock_period_s * std::ceil((begin_s - phase_s) / clock_period_s) - begin_s;
    std::size_t next = 0;
    while (next < taken.size()) {
        std::size_t newest = next;
        while (newest < taken.size() && period_s * static_cast<double>(newest) + arrival_s <= latch_s) {
            newest++;
        }
        if (newest > next) {
            add_knot(knots, latch_s + dead_time_s, taken[newest - 1], clock_period_s, holds);
            next = newest;
        }
        latch_s += clock_period_s;
    }
    return knots;
}

/* Walks along the reference, forwards. */
class reference
{
  public:
    reference(const std::vector<knot> &knots, bool holds) : knots_(knots), holds_(holds) {}

    double at(double time_s)
    {
        while (next_ < knots_.size() && knots_[next_].time_s <= time_s) {
            next_++;
        }
        return on_line(time_s);
    }

    /* The same; `bulge_m`: see robot_way, of the way there from `from_s`, where the walk is. */
    double at(double time_s, double from_s, double from_m, double &bulge_m)
    {
        double area_m_s = 0.0;
        double begin_s = from_s;
        double begin_m = from_m;
        while (next_ < knots_.size() && knots_[next_].time_s <= time_s) {
            const double end_s = knots_[next_].time_s;
            area_m_s += 0.5 * (begin_m + on_line(end_s)) * (end_s - begin_s);
            begin_s = end_s;
            begin_m = knots_[next_].position_m;
            next_++;
        }
        const double to_m = on_line(time_s);
        area_m_s += 0.5 * (begin_m + to_m) * (time_s - begin_s);
        bulge_m = area_m_s / (time_s - from_s) - 0.5 * (from_m + to_m);
        return to_m;
    }

  private:
    /* Between the knots that the walk is between. */
    double on_line(double time_s) const
    {
        if (next_ == 0) {
            return knots_.front().position_m;
        }
        const knot &before = knots_[next_ - 1];
        if (holds_ || next_ == knots_.size()) {
            return before.position_m;
        }
        const knot &after = knots_[next_];
        return before.position_m +
               (after.position_m - before.position_m) * (time_s - before.time_s) / (after.time_s - before.time_s);
    }

    const std::vector<knot> &knots_;
    bool holds_;
    std::size_t next_ = 0;
};

/* Where a robot with play begins; without, where the reference does. */
double start_in_play_m(const rig &rig, const record &record, const record_segment &part, reference line)
{
    const double begin_m = line.at(0.0);
    const double gap_m = 0.5 * value_of_effect(rig, "robot.backlash_m");
    if (gap_m == 0.0 || part.stands_m) {
        return begin_m;
    }
    std::vector<double> goal_m = {begin_m};
    for (std::size_t n = part.begin + 1; n < part.end && std::abs(goal_m.back() - begin_m) <= 2.0 * gap_m; n++) {
        goal_m.push_back(line.at(record.period_s * static_cast<double>(n - part.begin)));
    }
    return seen_before_it_moves_m(record, part, goal_m, gap_m);
}

/* Within the ticks, so that they cannot be the ends of steps. */
bool knots_wander(const rig &rig)
{
    return rig.robot.clock == robot_clock::free || value_of_effect(rig, "robot.dead_time_drift_ms_per_s") != 0.0;
}

/* At the same place of every tick. */
bool jumps_within_ticks(const rig &rig)
{
    return rig.robot.interpolation == interpolation::hold && !knots_wander(rig) && !limits_reference(rig);
}

/* Transfer behaviour and effects are each exact at the end of a step in which what drives them is straight: a single
 * one needs no steps of its own, unless the way between the ticks counts. */
int steps_of_motion(const rig &rig, motion_detail detail)
{
    const std::size_t effects = active_stages(rig, &effect::on_motion).size();
    const std::size_t in_a_row = effects + (rig.has_transfer_behaviour() ? 1 : 0);
    const bool is_cornered = limits_reference(rig);
    if ((in_a_row == 0 && !is_cornered) ||
        (in_a_row + (is_cornered ? 1 : 0) == 1 && detail == motion_detail::at_ticks)) {
        return 1;
    }
    return effects > 0 || is_cornered ? cornered_steps_a_tick : fine_steps_a_tick;
}

} // namespace

tick_steps divide_tick(const rig &rig, double period_s, int steps_min)
{
    const bool wander = knots_wander(rig);
    const double least_s = 1e-6 * period_s;
    const double after_tick_s =
        wander ? 0.0
               : std::fmod(1e-3 * rig.robot.dead_time_ms + 1e-9 * static_cast<double>(sync_wait_ns(rig)), period_s);
    const double knot_s = after_tick_s < least_s ? period_s : after_tick_s;
    const double late =
        (1e-3 * rig.sensor.delay_ms - std::fmod(1e-3 * rig.sensor.sample_phase_ms, period_s)) / period_s;
    const double whole = std::ceil(late - 1e-9);
    const double sample_s = std::max(0.0, (whole - late) * period_s);

    std::vector<double> ends;
    const double jump_s = jumps_within_ticks(rig) ? jump_lasts * period_s : 0.0;
    for (const double end_s : {knot_s, knot_s - jump_s, sample_s}) {
        if (end_s > least_s && end_s < period_s - least_s) {
            ends.push_back(end_s);
        }
    }
    std::sort(ends.begin(), ends.end());
    ends.push_back(period_s);
    const double step_max_s = period_s / std::max(steps_min, wander ? fine_steps_a_tick : 1) * (1.0 + 1e-9);
    tick_steps tick;
    tick.ticks_late = static_cast<std::ptrdiff_t>(whole);
    double begin_s = 0.0;
    for (const double end_s : ends) {
        if (end_s - begin_s < least_s) {
            continue;
        }
        const int parts = static_cast<int>(std::ceil((end_s - begin_s) / step_max_s));
        for (int i = 0; i < parts; i++) {
            tick.duration_s.push_back((end_s - begin_s) / parts);
            tick.kind.push_back(tick.kinds);
        }
        tick.kinds++;
        begin_s = end_s;
        if (std::abs(end_s - sample_s) < least_s) {
            tick.sample_after = tick.duration_s.size();
        }
    }
    if (tick.sample_after == tick.count()) {
        tick.sample_after = 0; /* the end of a tick is the start of the next one */
        tick.ticks_late -= 1;
    }
    return tick;
}

double setpoint_arrival_s(const rig &rig)
{
    return 1e-9 * static_cast<double>(robot_frames_a_tick(rig) * frame_time_ns(rig.bus, 8));
}

void replay_robot(const rig &rig, const record &record, const sample_events &events, motion_detail detail,
                  int steps_min, robot_motion &motion)
{
    const double period_s = record.period_s;
    const bool is_limited = limits_reference(rig);
    const bool holds = rig.robot.interpolation == interpolation::hold;
    const bool jumps = jumps_within_ticks(rig);
    const bool has_motion_effect = !active_stages(rig, &effect::on_motion).empty();
    const int steps = std::max(steps_of_motion(rig, detail), steps_min);
    motion.tick = divide_tick(rig, period_s, steps);
    motion.position_m.resize(record.size() * motion.tick.count() + record.segments.size());
    motion.at_tick_m.resize(record.size());
    const bool has_late_knots =
        (knots_wander(rig) || is_limited) && !rig.has_transfer_behaviour() && !has_motion_effect;
    motion.bulge_m.assign(has_late_knots || has_motion_effect ? motion.position_m.size() : 0, 0.0);

    double *out = motion.position_m.data();
    for (const record_segment &part : record.segments) {
        std::vector<knot> knots = reference_knots(rig, record, part, events);
        if (knots.empty()) {
            continue;
        }
        if (is_limited) {
            knots = with_limited_velocity(knots, holds, rig.robot.velocity_limit_m_per_s);
        }
        reference line(knots, holds && !is_limited);
        robot_drive drive(rig);
        double goal_m = knots.front().position_m;
        double position_m = drive.start(goal_m, start_in_play_m(rig, record, part, line));
        *out++ = position_m;
        for (std::size_t n = part.begin; n < part.end; n++) {
            motion.at_tick_m[n] = position_m;
            double time_s = period_s * static_cast<double>(n - part.begin);
            for (const double step_s : motion.tick.duration_s) {
                const double begin_s = time_s;
                time_s += step_s;
                const auto at = static_cast<std::size_t>(out - motion.position_m.data());
                if (has_late_knots) {
                    position_m = line.at(time_s, begin_s, position_m, motion.bulge_m[at]);
                } else {
                    position_m = drive.advance(jumps ? goal_m : line.at(time_s), step_s);
                }
                if (has_motion_effect) {
                    motion.bulge_m[at] = drive.bulge_m();
                }
                if (jumps && line.at(time_s) != goal_m) {
                    goal_m = line.at(time_s);
                    position_m = drive.jump(goal_m);
                }
                *out++ = position_m;
            }
        }
    }
    /* Without corners the object can go by whole ticks. */
    const bool has_corners =
        std::any_of(motion.bulge_m.begin(), motion.bulge_m.end(), [](double bulge_m) { return bulge_m != 0.0; });
    if (!has_corners) {
        motion.bulge_m.clear();
    }
}

} // namespace berth
