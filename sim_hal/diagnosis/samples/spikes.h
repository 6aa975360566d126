/* Single samples of the force that something has thrown far off. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_SPIKES_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_SPIKES_H

#include <vector>

#include "events.h"

namespace berth
{

constexpr double spike_far_sd = 7.0; /* off the neighbours; of 24000 normal samples none lies beyond 5 */

/* Where the robot jumps at another tick than ours, a stiff contact has spikes that are none, each of its own size.
 */
enum class spikes_wanted { all, of_one_size };

/* Single samples far off their neighbours, in the error of the force. Sets the rows in `events`. */
std::vector<event_finding> find_spikes(const block_model &model, const std::vector<double> &error,
                                       sample_events &events, spikes_wanted wanted = spikes_wanted::all);

} // namespace berth

#endif
