/* How fast a loop grows that changes from tick to tick: its Lyapunov exponent, the mean growth of a small
 * disturbance along one timeline. For a loop that does not change it is ln|z|/T of the largest eigenvalue. */
#ifndef SIM_HAL_STABILITY_LYAPUNOV_H
#define SIM_HAL_STABILITY_LYAPUNOV_H

#include <cstdint>
#include <memory>
#include <vector>

#include "hardware_chain.h"
#include "loop_timeline.h"

namespace berth
{

struct lyapunov_exponent {
    double growth_per_s;
    double ci95_per_s; /* by what other seeds would give, from the scatter of parts of the sequence */
    std::int64_t ticks;
};

/* Transitions of the hardware by their duration: a few that come again and again, or all different. */
class transition_cache
{
  public:
    transition_cache();

    /* Of the one chain that is asked for since the last forget(). */
    const hardware_chain::transition &over(const hardware_chain &chain, std::int64_t duration_ns)
    {
        const auto hash = static_cast<std::uint64_t>(duration_ns) * 0x9e3779b97f4a7c15u;
        const std::size_t place = hash >> (64 - size_bits);
        if (kept_ns_[place] != duration_ns) {
            chain.set_transition(kept_[place], static_cast<double>(duration_ns) * 1e-9);
            kept_ns_[place] = duration_ns;
        }
        return kept_[place];
    }
    void forget();

  private:
    static constexpr int size_bits = 11;
    static constexpr std::size_t size = std::size_t{1} << size_bits;
    std::vector<std::int64_t> kept_ns_;
    std::unique_ptr<hardware_chain::transition[]> kept_;
};

/* Finds exponents of many rigs along timelines without asking for memory again. */
class exponent_finder
{
  public:
    /* Of a rig along a timeline with its timing. Throws input_error for contact. */
    lyapunov_exponent along(const rig &rig, const loop_timeline &timeline);

  private:
    transition_cache cache_;
    std::vector<double> logarithms_;
};

/* Over `ticks` ticks of the rig's seed; 0: over as many as it takes to know it to 1 % or 0.001 /s, whatever is more,
 * and over several drifts of a free clock through a period. */
lyapunov_exponent exponent_of(const rig &rig, const wake_histogram &histogram, std::int64_t ticks = 0);

} // namespace berth

#endif
