#include "scheduled_rig.h"

#include <algorithm>

#include "../../hal/rig/axes.h"
#include "../../hal/rig/rig_file.h"
#include "../effects/active.h"
#include "loop_timeline.h"

namespace berth
{

namespace
{

constexpr const char *dead_time_drift = "robot.dead_time_drift_ms_per_s";
constexpr const char *stiffness_drift = "object.stiffness_drift_per_s";

/* A drift is looked at in so many steps: a stable or unstable stretch shorter than one may be overlooked. */
constexpr int drift_steps = 16;
constexpr int drift_steps_if_slow = 4; /* each takes a good part of a second */

bool drifts(const rig &rig)
{
    return value_of_effect(rig, dead_time_drift) != 0.0 || value_of_effect(rig, stiffness_drift) != 0.0;
}

struct time_span {
    double from_s;
    double to_s;
};

/* In which the loop is closed. */
time_span closed_span(const run_rig &run)
{
    return {std::max(run.release_s, run.grip_close_s),
            std::min({run.duration_s, run.grip_release_s, run.emergency_stop_s, run.enable_off_s})};
}

bool jumps_within(const rig &rig, const time_span &closed)
{
    return rig.run.dead_time_jump_ms != 0.0 && rig.run.dead_time_jump_s < closed.to_s;
}

/* As robot.cpp has it: a dead time that drifts stays longer than a period. */
double dead_time_ms(const rig &rig, double at_s)
{
    const double told_ms =
        rig.robot.dead_time_ms + (at_s < rig.run.dead_time_jump_s ? 0.0 : rig.run.dead_time_jump_ms);
    const double drift_ms = value_of_effect(rig, dead_time_drift) * at_s;
    const double shortest_ms = std::min(rig.robot.dead_time_ms, 1e3 * config_period_s(&rig.firmware));
    return drift_ms == 0.0 ? told_ms : std::max(told_ms + drift_ms, shortest_ms);
}

} // namespace

bool has_schedule(const rig &rig)
{
    const time_span closed = closed_span(rig.run);
    return !touches_nothing(rig) && closed.from_s < closed.to_s && (jumps_within(rig, closed) || drifts(rig));
}

std::vector<double> instants_of_schedule(const rig &rig)
{
    const time_span closed = closed_span(rig.run);
    std::vector<double> times_s{closed.from_s};
    if (jumps_within(rig, closed) && rig.run.dead_time_jump_s > closed.from_s) {
        times_s.push_back(rig.run.dead_time_jump_s);
    }
    if (drifts(rig)) {
        const int steps = is_time_varying(rig) ? drift_steps_if_slow : drift_steps;
        for (int i = 1; i <= steps; i++) {
            times_s.push_back(closed.from_s + (closed.to_s - closed.from_s) * i / steps);
        }
        std::sort(times_s.begin(), times_s.end());
        times_s.erase(std::unique(times_s.begin(), times_s.end()), times_s.end());
    }
    return times_s;
}

/* The firmware goes on with what it was told. */
rig rig_at(const rig &original, double at_s)
{
    rig made = original;
    made.run.dead_time_jump_s = never;
    made.run.dead_time_jump_ms = 0.0;
    move_dead_time(made, dead_time_ms(original, at_s));
    made.object.stiffness_N_per_m *= 1.0 + value_of_effect(original, stiffness_drift) * at_s;
    set_number(made, dead_time_drift, 0.0);
    set_number(made, stiffness_drift, 0.0);
    return made;
}

std::string reason_against(const rig &original, const rig &at)
{
    if (at.object.kind == object_kind::beam && value_of_effect(original, stiffness_drift) != 0.0) {
        return "object.stiffness_drift_per_s changes no single mode of a beam: run it";
    }
    if (at.object.stiffness_N_per_m < 0.0) {
        return "object.stiffness_drift_per_s leaves the object a stiffness below 0";
    }
    if (at.robot.dead_time_ms < std::min(original.robot.dead_time_ms, 2e3 * config_period_s(&at.firmware))) {
        return "robot.dead_time_drift_ms_per_s leaves the robot a dead time below 2 periods";
    }
    return {};
}

} // namespace berth
