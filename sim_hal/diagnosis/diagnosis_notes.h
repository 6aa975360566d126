/* What a record leaves open, whatever the verdict is. */
#ifndef SIM_HAL_DIAGNOSIS_DIAGNOSIS_NOTES_H
#define SIM_HAL_DIAGNOSIS_DIAGNOSIS_NOTES_H

#include "diagnosis.h"

namespace berth
{

/* What the rig file's delay of the force comes to. `given`: the rig before its age was taken as its delay. */
void tell_sample_age(diagnosis &result, const rig &given);

/* Tolerances of the rig file that are not used, as nothing is re-tuned in their keys. `given`: with them. */
void tell_tolerances_without_use(diagnosis &result, const rig &given);

/* What a command with too few digits hides. */
void tell_input_steps(diagnosis &result);

/* What the noise of a measured motion makes of the force. */
void tell_motion_noise(diagnosis &result, const sample_events &events);

/* A force that is scaled wrongly looks like a manipulator of which mass, damping and stiffness are. */
void tell_scaled_manipulator(diagnosis &result);

/* A log's force from another zero than the one that the firmware got is two causes, of which neither is there. */
void tell_other_zero_of_force(diagnosis &result);

/* A delay that is off by whole rows may be that of the log. */
void tell_delay_of_rows(diagnosis &result);

/* What was left out as the limit of work was over. */
void tell_not_tried(diagnosis &result, const work_limit &limit);

} // namespace berth

#endif
