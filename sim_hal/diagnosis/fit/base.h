/* The base: the rig as given, re-tuned within the tolerances of its file. */
#ifndef SIM_HAL_DIAGNOSIS_FIT_BASE_H
#define SIM_HAL_DIAGNOSIS_FIT_BASE_H

#include <string_view>
#include <vector>

#include "../replay/block_model.h"
#include "prior.h"

namespace berth
{

/* The base's parameters in a block, free within their tolerances: those of the base model, known to 5 % where the
 * rig file says nothing, and those of effects that the rig has, as far as their tolerances are stated. */
std::vector<free_parameter> base_parameters(block block, const rig &given);

/* States the usual tolerance for the effects that the rig file has and says no tolerance of. What a diagnosis finds
 * later and takes for known has none then: it stays as found. */
void state_tolerances_of_effects(rig &given);

/* Keys with a tolerance that are none of the base's or of an effect that the rig has. */
std::vector<std::string_view> tolerances_without_use(const rig &given);

} // namespace berth

#endif
