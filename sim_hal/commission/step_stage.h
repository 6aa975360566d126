/* The stage step: the robot by itself, judged by the diagnosis. */
#ifndef SIM_HAL_COMMISSION_STEP_STAGE_H
#define SIM_HAL_COMMISSION_STEP_STAGE_H

#include "../diagnosis/diagnosis.h"
#include "commission.h"

namespace berth
{

/* Where the log of the stage on the simulated rig is written. */
std::string stage_log(const stage_request &request);

/* Diagnoses the log of `run`. */
stage_entry judge_step(const stage_request &request, const stage_rigs &rigs, const stage_run &run);

/* What a diagnosis of the robot alone means for the rig file: a pure function. `given`: as it was assumed to be. */
stage_entry step_entry(const diagnosis &found, const rig &given);

} // namespace berth

#endif
