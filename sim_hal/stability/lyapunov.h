/* How fast a loop grows that changes from tick to tick: its Lyapunov exponent, the mean growth of a small
 * disturbance along one timeline. For a loop that does not change it is ln|z|/T of the largest eigenvalue. */
#ifndef SIM_HAL_STABILITY_LYAPUNOV_H
#define SIM_HAL_STABILITY_LYAPUNOV_H

#include <cstdint>
#include <vector>

#include "linear_loop.h"

namespace berth
{

struct lyapunov_exponent {
    double growth_per_s;
    double ci95_per_s; /* by what other seeds would give, from the scatter of parts of the sequence */
    std::int64_t ticks;
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
