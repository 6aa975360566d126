/* What makes an unstable loop stable, or ends a stable one's stability. */
#ifndef SIM_HAL_ADVICE_H
#define SIM_HAL_ADVICE_H

#include <optional>
#include <string>
#include <vector>

#include "stability/limits.h"

namespace berth
{

/* The limit that the smallest factor of its parameter leads to. */
struct near_limit {
    std::string key;    /* of the parameter */
    double value = 0.0; /* the rig's own */
    stability_limit limit;

    double factor() const { return limit.value / value; }
};

/* Nothing where there is none. A rough value warns of where stability may end, but is no advice on how to gain it.
 */
std::optional<near_limit> nearest_limit(const std::vector<parameter_limits> &parameters, bool is_stable);

/* A compensation that makes the loop stable. */
struct cure {
    std::string with; /* as --with names it */
    double growth_per_s;
};

struct stability_advice {
    std::optional<near_limit> change;
    std::optional<cure> compensation;
};

/* Of a rig that its eigenvalues call unstable; empty where there are none. Parameters change by up to a factor of
 * 10, in steps of 2 %: a stable interval narrower than that may be overlooked. */
stability_advice advise(const rig &rig);

/* "object.mass_kg below 194.6, or --with prediction: -0.47 /s"; empty: none. */
std::string advice_text(const stability_advice &advice);

} // namespace berth

#endif
