#include "robot_reference.h"

#include <algorithm>
#include <cmath>

#include "../../effects/active.h"
#include "../../effects/setpoint_path.h"
#include "../../effects/velocity_follower.h"
#include "robot_start.h"

namespace berth
{

namespace
{

/* Setpoints of one segment as the robot takes them; of a lost one the place before it. */
std::vector<double> taken_setpoints(const rig &rig, const record &record, const record_segment &part,
                                    const sample_events &events)
{
    setpoint_path path(rig);
    const double *const sent_m = record.command_position_m.data();
    if (path.is_plain() && events.lost_command.empty()) {
        return {sent_m + part.begin, sent_m + part.end};
    }
    std::vector<double> taken(part.end - part.begin);
    path.start(stands_on_m(rig, record, part));
    for (std::size_t n = 0; n < taken.size(); n++) {
        const bool is_lost = !events.lost_command.empty() && events.lost_command[part.begin + n] != 0;
        taken[n] = is_lost ? path.go_on() : path.take(sent_m[part.begin + n]);
    }
    return taken;
}

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

std::vector<knot> knots_of_setpoints(const rig &rig, const record &record, const record_segment &part,
                                     const sample_events &events)
{
    const std::vector<double> taken = taken_setpoints(rig, record, part, events);
    const double period_s = record.period_s;
    const double dead_time_s = 1e-3 * rig.robot.dead_time_ms + 1e-9 * static_cast<double>(sync_wait_ns(rig));
    const double drift = 1e-3 * value_of_effect(rig, "robot.dead_time_drift_ms_per_s");
    const bool holds = rig.robot.interpolation == interpolation::hold;
    const bool goes_on = setpoint_path(rig).goes_on();
    const auto is_lost = [&](std::size_t n) {
        return !goes_on && !events.lost_command.empty() && events.lost_command[part.begin + n] != 0;
    };
    const bool is_locked = rig.robot.clock == robot_clock::locked;
    std::vector<knot> knots;
    /* As in nearly all replays of a diagnosis: each setpoint is one knot. */
    if (is_locked && events.lost_command.empty() && drift == 0.0 && !holds && !part.stands_m) {
        knots.resize(taken.size());
        for (std::size_t n = 0; n < taken.size(); n++) {
            knots[n] = {period_s * static_cast<double>(n) + dead_time_s, taken[n]};
        }
        return knots;
    }
    knots.reserve(taken.size() + 16);
    if (part.stands_m) {
        knots.push_back({-period_s, setpoint_path(rig).start(*part.stands_m)});
    }
    if (is_locked) {
        for (std::size_t n = 0; n < taken.size(); n++) {
            if (!is_lost(n)) {
                const double sent_s = period_s * static_cast<double>(n);
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

} // namespace

double setpoint_arrival_s(const rig &rig)
{
    return 1e-9 * static_cast<double>(robot_frames_a_tick(rig) * frame_time_ns(rig.bus, 8));
}

double stands_on_m(const rig &rig, const record &record, const record_segment &part)
{
    if (part.stands_m) {
        return *part.stands_m;
    }
    const double *const wanted_m = record.command_position_m.data();
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

std::vector<knot> reference_knots(const rig &rig, const record &record, const record_segment &part,
                                  const sample_events &events)
{
    std::vector<knot> knots = knots_of_setpoints(rig, record, part, events);
    if (limits_reference(rig) && !knots.empty()) {
        const bool holds = rig.robot.interpolation == interpolation::hold;
        return with_limited_velocity(knots, holds, rig.robot.velocity_limit_m_per_s);
    }
    return knots;
}

} // namespace berth
