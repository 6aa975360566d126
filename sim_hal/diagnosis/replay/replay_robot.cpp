#include <algorithm>
#include <cmath>

#include "../../effects/robot_drive.h"
#include "../../solver/object_steps.h"
#include "../record/measured_motion.h"
#include "replay.h"
#include "robot_reference.h"
#include "robot_start.h"

namespace berth
{

namespace
{

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

/* The way of a transfer behaviour is a parabola within a step. In steps of a 20th of a radian of its frequency the
 * force of `ess` has an error of 1e-7 N, which grows with the fourth power of the step. */
int steps_of_transfer(const rig &rig)
{
    constexpr double step_rad = 0.05;
    constexpr double steps_max = 32.0;
    const double tick_rad =
        6.28318530717958647692 * rig.robot.transfer_frequency_Hz * config_period_s(&rig.firmware);
    return std::max(fine_steps_a_tick, static_cast<int>(std::ceil(std::min(tick_rad / step_rad, steps_max))));
}

/* Transfer behaviour and effects are each exact at the end of a step in which what drives them is straight: a single
 * one needs no steps of its own, nor does what comes after it without a memory, unless the way between the ticks
 * counts. */
int steps_of_motion(const rig &rig, motion_detail detail)
{
    const auto stages = active_stages(rig, &effect::on_motion);
    std::size_t effects = stages.size();
    while (detail == motion_detail::at_ticks && effects > 0 && !stages[effects - 1]->has_memory()) {
        effects--;
    }
    const bool is_cornered = limits_reference(rig);
    const std::size_t in_a_row = effects + (rig.has_transfer_behaviour() ? 1 : 0) + (is_cornered ? 1 : 0);
    if (in_a_row == 0 || (in_a_row == 1 && detail == motion_detail::at_ticks)) {
        return 1;
    }
    const int of_transfer = rig.has_transfer_behaviour() ? steps_of_transfer(rig) : fine_steps_a_tick;
    return effects > 0 || is_cornered ? std::max(cornered_steps_a_tick, of_transfer) : of_transfer;
}

} // namespace

tick_steps divide_tick(const rig &rig, double period_s, int steps_min)
{
    const bool wander = knots_wander(rig);
    const double least_s = 0.1 * jump_lasts * period_s;
    const double after_tick_s =
        wander ? 0.0
               : std::fmod(1e-3 * rig.robot.dead_time_ms + 1e-9 * static_cast<double>(sync_wait_ns(rig)), period_s);
    const double knot_s = after_tick_s < least_s ? period_s : after_tick_s;
    const double late = 1e-3 * rig.sensor.delay_ms / period_s;
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

namespace
{

/* What is the same for all segments. */
struct way_of_robot {
    double period_s;
    bool jumps;
    bool has_transfer;
    bool has_stages;
    bool has_late_knots; /* the reference itself has corners within steps, and the robot follows it */

    bool is_the_reference() const { return !has_transfer && !has_stages; }
};

/* The reference goes on to `time_s`, and the robot behind it. */
double advance(const way_of_robot &way, reference &line, robot_drive &drive, double &goal_m, double time_s,
               double step_s)
{
    if (!way.jumps) {
        return drive.advance(line.at(time_s), step_s);
    }
    const double position_m = drive.advance(goal_m, step_s);
    const double next_m = line.at(time_s);
    if (next_m == goal_m) {
        return position_m;
    }
    goal_m = next_m;
    return drive.jump(goal_m);
}

void walk_by_ticks(const way_of_robot &way, const record_segment &part, reference line, robot_drive &drive,
                   double goal_m, double position_m, robot_motion &motion)
{
    for (std::size_t n = part.begin; n < part.end; n++) {
        motion.at_tick_m[n] = position_m;
        double time_s = way.period_s * static_cast<double>(n - part.begin);
        if (way.is_the_reference()) {
            position_m = line.at(time_s + way.period_s);
            continue;
        }
        for (const double step_s : motion.tick.duration_s) {
            time_s += step_s;
            position_m = advance(way, line, drive, goal_m, time_s, step_s);
        }
    }
}

/* `at`: where the segment begins in the motion's steps; returns where the next one does. */
std::size_t walk_by_steps(const way_of_robot &way, const record_segment &part, reference line, robot_drive &drive,
                          double goal_m, double position_m, robot_motion &motion, std::size_t at)
{
    motion.position_m[at++] = position_m;
    for (std::size_t n = part.begin; n < part.end; n++) {
        motion.at_tick_m[n] = position_m;
        double time_s = way.period_s * static_cast<double>(n - part.begin);
        for (const double step_s : motion.tick.duration_s) {
            const double begin_s = time_s;
            time_s += step_s;
            if (way.has_late_knots) {
                position_m = line.at(time_s, begin_s, position_m, motion.bulge_m[at]);
            } else {
                position_m = advance(way, line, drive, goal_m, time_s, step_s);
            }
            if (!way.is_the_reference()) {
                motion.bulge_m[at] = drive.bulge_m();
            }
            motion.position_m[at++] = position_m;
        }
    }
    return at;
}

} // namespace

void replay_robot(const rig &rig, const record &record, const sample_events &events, motion_detail detail,
                  int steps_min, robot_motion &motion)
{
    if (record.moves_as_measured()) {
        replay_measured_motion(rig, record, steps_min, motion);
        return;
    }
    const bool is_limited = limits_reference(rig);
    const bool holds = rig.robot.interpolation == interpolation::hold;
    way_of_robot way{record.period_s, jumps_within_ticks(rig), rig.has_transfer_behaviour(),
                     !active_stages(rig, &effect::on_motion).empty(), false};
    way.has_late_knots = (knots_wander(rig) || is_limited) && way.is_the_reference();
    motion.tick = divide_tick(rig, record.period_s, std::max(steps_of_motion(rig, detail), steps_min));
    motion.at_tick_m.resize(record.size());
    const std::size_t steps =
        detail == motion_detail::way ? record.size() * motion.tick.count() + record.segments.size() : 0;
    motion.position_m.resize(steps);
    motion.bulge_m.assign(way.has_late_knots || !way.is_the_reference() ? steps : 0, 0.0);

    std::size_t at = 0;
    for (const record_segment &part : record.segments) {
        const std::vector<knot> knots = reference_knots(rig, record, part, events);
        if (knots.empty()) {
            continue;
        }
        const reference line(knots, holds && !is_limited);
        robot_drive drive(rig);
        const double goal_m = knots.front().position_m;
        const double position_m = drive.start(goal_m, start_in_play_m(rig, record, part, line));
        if (detail == motion_detail::at_ticks) {
            walk_by_ticks(way, part, line, drive, goal_m, position_m, motion);
        } else {
            at = walk_by_steps(way, part, line, drive, goal_m, position_m, motion, at);
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
