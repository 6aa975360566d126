#include "start_trial.h"

#include <cstdio>
#include <memory>

#include "../firmware/supervisor.h"
#include "hil/manipulator_stand_in.h"
#include "hil/sim_hal.h"
#include "stability/loop_timeline.h"

namespace berth
{

std::string obstacles_of(const rig &rig, const tick_record &last)
{
    if (rig.run.duration_s <= rig.run.release_s) { /* nobody requested to run, and nothing else has to be wrong */
        return ": run.duration_s is not longer than run.release_s, when the operator requests to run";
    }
    const struct {
        uint32_t condition;
        bool is_needed;
        bool comes_last; /* follows from the others: told where it stands alone */
        const char *name;
    } obstacles[] = {
        {CONDITION_EMERGENCY_STOP, false, false, "emergency stop is pressed"},
        {CONDITION_FEEDBACK_FRESH, true, false, "no fresh feedback from the robot"},
        {CONDITION_SENSOR_FRESH, true, false, "no fresh force"},
        {CONDITION_OPERATOR_FRESH, true, false, "no fresh operator command"},
        {CONDITION_ROBOT_AT_PLACE, true, false, "the robot is not at its first setpoint"},
        {CONDITION_ROBOT_FAULT, false, false, "the robot reports a fault"},
        {CONDITION_SENSOR_SATURATED, false, false, "the force sensor is saturated"},
        {CONDITION_FORCE_LIMIT, false, false, "the force is beyond sensor_channel.force_limit_N"},
        {CONDITION_BUS_OFF, false, false, "a bus is off"},
        {CONDITION_ROBOT_FOLLOWS, true, true, "the drive is not enabled"},
        {CONDITION_ENABLE, true, true, "enable is off"},
        {CONDITION_REQUEST_RUN, true, true, "the operator does not request to run"},
    };
    std::string text;
    for (const auto &obstacle : obstacles) {
        const bool stands = ((last.conditions & obstacle.condition) != 0) != obstacle.is_needed;
        if (stands && (text.empty() || !obstacle.comes_last)) {
            text += (text.empty() ? ": " : ", ") + std::string(obstacle.name);
        }
    }
    return text;
}

start_trial try_start(const rig &rig, double running_s)
{
    const std::unique_ptr<struct hal, hal_status (*)(struct hal *)> hal(sim_open(rig), hal_close);
    const auto app = std::make_unique<struct app>();
    app_start(app.get(), &rig.firmware);
    manipulator_stand_in manipulator(rig);
    const double period_s = config_period_s(&rig.firmware);
    start_trial found;
    std::int64_t left_ticks = 1 + static_cast<std::int64_t>(running_s / period_s);
    tick_record last{};
    while (left_ticks > 0 && manipulator.tick(hal.get(), *app)) {
        last = app->recorder.tick;
        if (app->supervisor.state == SUPERVISOR_RUNNING) {
            found.has_run = true;
            left_ticks--;
        }
        const bool is_ordered = app->supervisor.stop_cause == STOP_EMERGENCY_STOP;
        if (app->supervisor.state == SUPERVISOR_FAULT && !is_ordered) {
            found.stop =
                run_stop{static_cast<stop_cause>(last.stop_cause), static_cast<double>(last.index) * period_s};
            break;
        }
    }
    if (!found.has_run) {
        found.obstacles = obstacles_of(rig, last);
    }
    return found;
}

bool never_runs(const rig &rig, const growth_prediction &prediction)
{
    return !prediction.growth_per_s && is_time_varying(rig) && !try_start(rig).has_run;
}

std::string trial_words(const start_trial &trial)
{
    if (trial.is_good()) {
        return "";
    }
    std::string words = trial.has_run ? "the run that the rig describes is stopped"
                                      : "the supervisor never comes to running" + trial.obstacles;
    if (trial.stop) {
        char text[100];
        std::snprintf(text, sizeof text, "%s after %.3g s: %s", trial.has_run ? "" : "; fault", trial.stop->after_s,
                      stop_cause_name(trial.stop->cause));
        words += text;
    }
    return words;
}

} // namespace berth
