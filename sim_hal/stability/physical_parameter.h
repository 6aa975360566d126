/* The physical parameters of a rig: which there are, and rigs with another value of one of them. */
#ifndef SIM_HAL_STABILITY_PHYSICAL_PARAMETER_H
#define SIM_HAL_STABILITY_PHYSICAL_PARAMETER_H

#include <optional>
#include <string_view>
#include <vector>

#include "../../hal/rig/keys.h"
#include "../../hal/rig/rig.h"

namespace berth
{

enum class parameter_scale { mass, stiffness, damping, ratio, frequency, delay };

/* Throws input_error where the key is no physical parameter. */
parameter_scale scale_of(std::string_view key);

/* Whether an advice may raise it: nobody cures a loop by a longer delay, even where one would help. */
bool may_be_raised(std::string_view key);

/* Keys of the physical parameters that this rig has. */
std::vector<std::string_view> physical_parameters(const rig &rig);

/* complete_and_check(), and whether the loop is the same in every period. */
std::optional<rig_error> complete_and_check_steady(rig &rig);

/* The rig with another value of one parameter; nothing where a rig file may not have it or the loop then changes
 * from period to period. */
std::optional<rig> with_value(const rig &original, const rig_key &key, double value);

/* What becomes of dead time, delay, phase and period of the samples where the rate changes: as long, or as many
 * periods. */
enum class delays_stay { in_ms, in_ticks };
rig at_rate(const rig &original, double rate_Hz, delays_stay delays);

/* A size of the parameter to look around where the rig's own value is 0. */
double usual_value(const rig &rig, parameter_scale kind);

} // namespace berth

#endif
