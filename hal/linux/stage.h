/* A stage of commissioning on the target: may it begin, and that it has run. A PC judges its log. */
#ifndef HAL_LINUX_STAGE_H
#define HAL_LINUX_STAGE_H

#include "../rig/commissioning.h"
#include "options.h"

namespace berth
{

/* The rig that the options ask for; with --stage, that of the stage. Throws input_error. */
rig target_rig_of(const target_options &options);

/* With --stage: notes in the record that it has run. Throws input_error. */
void note_stage(const target_options &options);

} // namespace berth

#endif
