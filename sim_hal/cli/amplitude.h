/* --amplitude: the size of the motion at which effects that depend on it are taken. */
#ifndef SIM_HAL_CLI_AMPLITUDE_H
#define SIM_HAL_CLI_AMPLITUDE_H

#include <nlohmann/json.hpp>

#include "../prediction.h"
#include "../stability/equivalent_loop.h"
#include "commands.h"

namespace berth
{

/* In m; 0 where nothing in the rig depends on it, or small motions are asked for. Throws input_error. */
double chosen_amplitude_m(const rig_arguments &arguments, const rig &rig);

/* The rig, a tool held in contact, or what is equivalent to it at an amplitude greater than 0. */
struct settled_rig {
    rig linear;
    bool has_settled; /* its frequency and its phases agree */
};
settled_rig settle_at(const rig &rig, double amplitude_m);
rig linear_at(const rig &rig, double amplitude_m);

/* What predicts at an amplitude, or of small motions at 0: predict_unscheduled(), without its limit on the number of
 * eigenvalues, and of a loop that changes from tick to tick over `ticks` ticks (0: as many as it takes). */
growth_predictor predictor_at(double amplitude_m, std::int64_t ticks = 0);

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
