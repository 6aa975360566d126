/* A model without some of its effects. */
#ifndef SIM_HAL_DIAGNOSIS_SEARCH_SWITCHED_OFF_H
#define SIM_HAL_DIAGNOSIS_SEARCH_SWITCHED_OFF_H

#include <vector>

#include "../fit/fit.h"

namespace berth
{

/* The keys of the effects as given; those that the base model fits too stay, within its bounds. */
rig switched_off(rig from, const std::vector<const effect *> &gone, const std::vector<free_parameter> &base,
                 const rig &given);

std::vector<free_parameter> parameters_of_others(std::vector<free_parameter> all,
                                                 const std::vector<const effect *> &gone);

} // namespace berth

#endif
