/* Setpoints that never reached the robot: seen in what came of them. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_LOST_COMMANDS_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_LOST_COMMANDS_H

#include "events.h"

namespace berth
{

constexpr double loss_clear_sd = 8.0; /* by which the loss of a setpoint must stand out */

/* Whether the setpoints marked as lost in `events` show in the force, too; `force` replays without them. */
bool force_knows_of(block_model &force, const rig &rig, const sample_events &events);

/* How lost setpoints are looked for where none of them is clear by itself. */
struct loss_search {
    double left_max = 0.1;     /* share of the error's squares that they may leave */
    bool decode_alone = false; /* as the search before did in the end */
    bool polish = false;       /* what was decoded, by replays: where they are found for the last time */
    bool was_decoded = false;  /* result */
};
constexpr double left_by_wrong_base = 0.3;  /* the same of a base that was tuned without them */
constexpr double left_by_wrong_limit = 0.6; /* the same where a limit or a dead band was, too */

/* Setpoints after which the robot stood for a period: each leaves the trace of a short way back in the error of the
 * robot's position, and of the force. Adds the rows to `events`; `model` replays with those that are there already.
 */
std::vector<event_finding> find_lost_commands(block_model &model, const rig &rig, const std::vector<double> &error,
                                              sample_events &events, loss_search &search);

} // namespace berth

#endif
