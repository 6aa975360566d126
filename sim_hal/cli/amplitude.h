/* --amplitude: the size of the motion at which effects that depend on it are taken. */
#ifndef SIM_HAL_CLI_AMPLITUDE_H
#define SIM_HAL_CLI_AMPLITUDE_H

#include <nlohmann/json.hpp>

#include "../loop_at_amplitude.h"
#include "commands.h"

namespace berth
{

/* In m; 0 where nothing in the rig depends on it, or small motions are asked for. Throws input_error. */
double chosen_amplitude_m(const rig_arguments &arguments, const rig &rig);

/* To stand behind a verdict: empty where it holds. */
const char *guess_text(bool has_settled);

/* "stable" in JSON. Null: nothing holds the two bodies, and all else decays; or the growth is no more than rounding.
 */
nlohmann::json stable_json(double growth_per_s, double spectral_radius, bool is_free);

/* The same: null where it would be a guess. */
nlohmann::json unless_guess(bool has_settled, const nlohmann::json &stable);

/* What replaced the effects, and where the loop swings for ever; null at amplitude 0. */
nlohmann::json describing_function_json(const rig &rig, double amplitude_m);
void print_describing_function(const nlohmann::json &told);

} // namespace berth

#endif
