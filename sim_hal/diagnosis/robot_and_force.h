/* What the force says of the robot before it: of causes that the robot's own reports do not show, or do not tell
 * apart.
 */
#ifndef SIM_HAL_DIAGNOSIS_ROBOT_AND_FORCE_H
#define SIM_HAL_DIAGNOSIS_ROBOT_AND_FORCE_H

#include "block_diagnosis.h"

namespace berth
{

/* What the diagnosis of a block begins with. */
struct block_start {
    diagnosis_input input;
    rig given;
    events_of_records events;
    std::vector<event_finding> found_events;
};

/* The force's input, where the robot has been diagnosed. `as_given`: the rig before any diagnosis; outlives `force`.
 */
void know_robot(diagnosis_input &force, const block_diagnosis &robot, const rig &as_given);

/* Judges both anew where the force leaves something that hides in the robot's reports, or refutes what they take for
 * the cause in favour of another that they cannot tell from it. */
void ask_force_about_robot(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                           const block_start &robot_start, const block_start &force_start, const rig &as_given);

/* A later block saw more of an effect that an earlier one had found already. */
void drop_repeated(block_diagnosis &before, const block_diagnosis &now);

/* What is left in the robot's reports may be what the force shows more of: then they are judged anew with it. */
void judge_robot_again(block_diagnosis &robot, const block_diagnosis &force, const diagnosis_input &input,
                       events_of_records events);

} // namespace berth

#endif
