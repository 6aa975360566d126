/* What happened to single samples: seen in the data themselves, not fitted. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_EVENTS_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_EVENTS_H

#include <string_view>
#include <vector>

#include "../replay/block_model.h"

namespace berth
{

constexpr std::size_t events_min = 5;  /* fewer may be anything */
constexpr double rounding_share = 0.3; /* of all that is not explained, as variances */

struct event_finding {
    const berth::effect *effect;
    std::vector<double> values; /* of its parameters */
    std::vector<double> ci95;
    std::size_t count; /* of samples concerned */
    bool in_bursts = false;
};

/* So many of so many samples, as an effect with the probability as its first parameter. */
event_finding found_in(const char *effect, std::size_t count, std::size_t of);

/* The same of the rows that count. Where one follows right on another more often than by chance, they come in
 * bursts, and the interval is as wide as that of a Markov chain with their correlation from row to row. */
event_finding found_in(const char *effect, std::size_t count, const std::vector<std::uint8_t> &rows,
                       const std::vector<std::uint8_t> &counted);

/* Samples that stay exactly what they were, more often than chance, while their neighbours change. Sets the rows in
 * `events`. */
std::vector<event_finding> find_repeats(const record &record, const rig &given, sample_events &events);

/* Steps in which the force comes. `noise_rms`: of the force. */
std::vector<event_finding> find_quantisation(const record &record, const rig &given, double noise_rms);

} // namespace berth

#endif
