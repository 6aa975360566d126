#include "dead_time_tracker.h"

/* Dead times go this many tolerances away. */
#define TOLERANCES_MAX 3.0

void dead_time_tracker_start(struct dead_time_tracker *tracker, const struct app_config *config,
                             const struct hardware_model *model)
{
    *tracker = (struct dead_time_tracker){.enabled = config->identification.enabled};
    tracker->period_s = config_period_s(config);
    const double dead_time_s = 1e-3 * model->setpoint_to_motion_ms;
    const double tolerance_s = config->identification.tolerance * dead_time_s;
    tracker->delay_ticks = (dead_time_s + 1e-3 * model->report_age_ms) / tracker->period_s;
    tracker->tolerance_squared = tolerance_s * tolerance_s;
    tracker->variance = tracker->tolerance_squared;
    tracker->noise_squared = config->identification.position_noise_m * config->identification.position_noise_m;
    const double share = tracker->period_s / config->identification.memory_s;
    tracker->forgetting = share < 1.0 ? share : 1.0;
    tracker->highest_s = TOLERANCES_MAX * tolerance_s;
    tracker->lowest_s = -0.8 * dead_time_s > -tracker->highest_s ? -0.8 * dead_time_s : -tracker->highest_s;
}

static void correct(struct dead_time_tracker *tracker, double reported_m)
{
    const double ticks = tracker->delay_ticks + tracker->longer_s / tracker->period_s;
    const double slope_m_per_s =
        (past_before(&tracker->robot_m, ticks - 0.5) - past_before(&tracker->robot_m, ticks + 0.5)) /
        tracker->period_s;
    const double spread = tracker->variance * slope_m_per_s * slope_m_per_s;
    const double gain = spread > 0.0 ? spread / (spread + tracker->noise_squared) : 0.0;
    if (gain > 0.0) {
        tracker->longer_s -= gain * (reported_m - past_before(&tracker->robot_m, ticks)) / slope_m_per_s;
    }
    tracker->variance *= 1.0 - gain;
    tracker->variance += tracker->forgetting * (tracker->tolerance_squared - tracker->variance);
    tracker->longer_s = tracker->longer_s > tracker->highest_s  ? tracker->highest_s
                        : tracker->longer_s < tracker->lowest_s ? tracker->lowest_s
                                                                : tracker->longer_s;
}

double dead_time_tracker_step(struct dead_time_tracker *tracker, const struct hardware_twin *twin, double reported_m)
{
    if (!tracker->enabled) {
        return 0.0;
    }
    const double robot_m = hardware_twin_robot_m(twin);
    if (!tracker->is_filled) {
        past_fill(&tracker->robot_m, robot_m);
        tracker->is_filled = 1;
    }
    past_add(&tracker->robot_m, robot_m);
    correct(tracker, reported_m - twin->model.surface_m);
    return tracker->longer_s / tracker->period_s;
}
