/* What the force tells of the robot's causes where the reports leave it open. */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_SHOWN_BY_FORCE_H
#define SIM_HAL_DIAGNOSIS_SEARCH_SHOWN_BY_FORCE_H

#include "robot_and_force.h"

namespace berth
{

/* A threshold of the robot that its reports know to a thousandth still switches in another tick now and then, and a
 * stiff contact shows each of them: of the sizes that the reports leave open the one that suits the force, if that
 * is clear. `input`: the force's. */
void refine_thresholds(block_diagnosis &robot, const diagnosis_input &input, const events_of_records &events);

/* A limit that hides in the noise of the reports, and that the force of a stiff contact shows to a thousandth, may
 * stand before a second cause: with the limit as the force has it, the reports are searched once more, and the force
 * behind what they show. Taken if nothing is left in the reports, and in the force no new cause and no clearly
 * larger error; the force then keeps the cause that it had shown, and where it needs no other its verdict.
 * `as_given`: the rig before any diagnosis. */
void explain_robot_beside_shown(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                                const block_start &robot_start, const block_start &force_start, const rig &as_given);

/* One cause may stand in for two within the noise of the reports, as a resonance for a lag and a dead time, and the
 * force that it was fitted with is predicted worse on data that no fit saw: then the reports are searched once more
 * without it. Taken if that names what explains the reports as well, and the force without a further cause. */
void let_unseen_force_tell_stand_in(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                                    const block_start &robot_start, const block_start &force_start,
                                    const rig &as_given);

} // namespace berth

#endif
