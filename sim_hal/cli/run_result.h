/* What a run leaves to tell, and telling it. */
#ifndef SIM_HAL_CLI_RUN_RESULT_H
#define SIM_HAL_CLI_RUN_RESULT_H

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "../../firmware/cia402_text.h"
#include "../../firmware/limits.h"
#include "../../firmware/recorder.h"
#include "../../firmware/supervisor.h"
#include "../../hal/rig/rig.h"
#include "../arm/step_accuracy.h"
#include "../berth.h"
#include "energy_report.h"
#include "guidance_report.h"
#include "motor_report.h"
#include "wheel_report.h"

namespace berth
{

struct run_result {
    explicit run_result(const rig &rig) : motion(rig) {}

    double wall_s = 0.0; /* 0: read from a log, which does not know */
    double simulated_s = 0.0;
    std::int64_t ticks = 0;
    std::int64_t overruns = 0;
    std::int64_t running_ticks = 0;
    motion_recorder motion;
    motion_evidence evidence; /* what the motion showed */
    supervisor_state state = SUPERVISOR_START;
    stop_cause cause = STOP_NONE;
    uint32_t limit_ticks[LIMIT_COUNT] = {};
    std::int64_t frames_accepted = 0;
    uint32_t frames_rejected = 0;
    uint32_t frames_lost = 0;
    uint32_t error_frames = 0;
    uint32_t saturated_setpoints = 0;
    uint32_t force_samples = 0;                /* whole ones */
    uint32_t torn_samples = 0;                 /* of which a frame was missing: rejected */
    uint32_t suspected_torn_samples = 0;       /* the same, of a sensor whose frames carry no number */
    std::int64_t force_age_min_ns = INT64_MAX; /* at use, while running */
    std::int64_t force_age_max_ns = 0;
    uint16_t drive_statusword = 0; /* profile "cia402", of the last tick; and what was wrong with the drive then */
    cia402_trouble drive_trouble = DRIVE_TROUBLE_NONE;
    uint32_t drive_error = 0;
    uint8_t drive_setup_step = 0;
    uint64_t dropped_records = 0;
    energy_report energy;
    guidance_report guidance;              /* of a rig with an arm */
    motor_report motors;                   /* of the same */
    wheel_report wheel;                    /* of the same */
    std::optional<step_accuracy> accuracy; /* of the same */
    std::string log;
    std::string robot = "null"; /* its preset, see robot_as_text() */
    std::string version;        /* of the program that ran the loop */
    std::vector<std::string> candumps;
    std::string runs_page; /* of all kept runs; empty: this one is not kept */

    growth_prediction predicted;
    stability_margin margin;
    stability_verdict verdict;
    std::string obstacles; /* what kept a loop that never ran from running */

    bool was_gripped() const { return evidence.has_touched; }
};

/* Takes one tick into account; `arm`: of a rig that has one; `spring_force_N`: of the sensor's spring, where it is
 * known.
 */
void note_tick(run_result &result, const rig &rig, const tick_record &record, const arm_record &arm,
               std::optional<double> spring_force_N);

/* Fills in what only the whole run tells, from its `last` tick: evidence, verdict, counts. */
void conclude(run_result &result, const rig &rig, const tick_record &last, answer_scope scope = answer_scope::whole);

/* For a person. */
void print_summary(const run_result &result, const rig &rig);

/* For a program. */
nlohmann::json as_json(const run_result &result, const rig &rig);

} // namespace berth

#endif
