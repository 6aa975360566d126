/* What the force says of the robot before it: of causes that the robot's own reports do not show, or do not tell
 * apart.
 */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_ROBOT_AND_FORCE_H
#define SIM_HAL_DIAGNOSIS_SEARCH_ROBOT_AND_FORCE_H

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

bool leaves_something(const block_diagnosis &block);

/* The robot's causes leave nearly as much in its reports as the re-tuned base does. */
bool hardly_shows(const block_diagnosis &robot);

/* What is left in `other` is less than in `one`, beyond chance. */
bool is_clearly_smaller(const block_diagnosis &other, const block_diagnosis &one);

/* The force's input, where the robot has been diagnosed. `as_given`: the rig before any diagnosis; outlives `force`.
 */
void know_robot(diagnosis_input &force, const block_diagnosis &robot, const rig &as_given);

/* Judges both anew where the force leaves something that hides in the robot's reports, or refutes what they take for
 * the cause in favour of another that they cannot tell from it. */
void ask_force_about_robot(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                           const block_start &robot_start, const block_start &force_start, const rig &as_given);

/* Where the force is what it should be with the robot as given, and needs causes of its own behind what the robot's
 * reports tell, the reports are off and not the motion: their causes are withdrawn. */
void doubt_reports(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                   const block_start &robot_start, const block_start &force_start);

/* A robot that is named rightly leaves the rest of it within its tolerances, whatever the force shows more of it;
 * `as_given`: the rig with what is known. */
void doubt_tolerances(block_diagnosis &robot, block_diagnosis &force, const rig &as_given);

/* No cause in the force is sure behind a robot that does what nothing explains, nor a late sensor behind a late
 * robot whose reports would not show it if that lateness were its own; nor what hardly shows in the reports of a
 * robot before a force that nothing explains. */
void doubt_force(block_diagnosis &robot, block_diagnosis &force, const block_start &robot_start,
                 const events_of_records &events);

/* A later block saw more of an effect that an earlier one had found already. */
void drop_repeated(block_diagnosis &before, const block_diagnosis &now);

/* The force was fitted with the robot's parameters free, as far as its reports had left them open: of what the later
 * block has refined, the earlier one tells the values that the extended rig gets. `given`: the rig before any
 * diagnosis. */
void take_refined(block_diagnosis &before, const block_diagnosis &now, const rig &given);

/* What the earlier block leaves with the rig that the later one has refined; `input`: the earlier one's. */
void measure_again(block_diagnosis &before, const rig &refined, const diagnosis_input &input,
                   const events_of_records &events);

/* What is left in the robot's reports may be what the force shows more of: then they are judged anew with it. */
void judge_robot_again(block_diagnosis &robot, const block_diagnosis &force, const diagnosis_input &input,
                       events_of_records events);

} // namespace berth

#endif
