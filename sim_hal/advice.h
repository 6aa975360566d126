/* What makes an unstable loop stable, or ends a stable one's stability. */
#ifndef SIM_HAL_ADVICE_H
#define SIM_HAL_ADVICE_H

#include <optional>
#include <string>
#include <vector>

#include "cure_search.h"
#include "stability/limits.h"

namespace berth
{

/* The limit that the smallest factor of its parameter leads to. */
struct near_limit {
    std::string key;     /* of the parameter */
    double value = 0.0;  /* the rig's own */
    double centre = 0.0; /* as in parameter_limits */
    stability_limit limit;

    /* Of an own value of 0: how far it is beside a usual one. */
    double factor() const { return value > 0.0 ? limit.value / value : 1.0 + limit.value / centre; }
};

/* Nothing where there is none. A rough value warns of where stability may end, but is no advice on how to gain it.
 */
std::optional<near_limit> nearest_limit(const std::vector<parameter_limits> &parameters, bool is_stable);

/* That change, a little beyond the limit; nothing where `predict` does not call the loop stable then. */
std::optional<parameter_cure> change_to(const rig &rig, const near_limit &limit, const growth_predictor &predict);

/* A compensation that makes the loop stable. */
struct cure {
    std::string option; /* of a command: "--with prediction" */
    double growth_per_s;
};

struct stability_advice {
    std::optional<parameter_cure> change;
    std::optional<cure> compensation;
    bool was_sought = false; /* a search that found nothing is reported, too */
    std::string caveat = {}; /* where the change cures not all */
};

/* The first one that helps more than barely; else the first one. */
std::optional<cure> find_compensation(const rig &rig, const growth_predictor &predict);

/* Of a rig that `predict` calls unstable, which calls it stable with each cure: less than 0 by more than interval or
 * rounding. Parameters change by up to a factor of 10, in steps of 2 % or as cure_search.h says: a stable interval
 * narrower than that may be overlooked. Where nothing cures and limits are known, by up to a factor of 1000, in
 * steps of 5 %. Empty where there is no prediction. */
stability_advice advise(const rig &rig, const growth_predictor &predict = predict_growth);

/* "object.mass_kg below 194.6, or --with prediction: -0.47 /s", or that none was found; empty: none was sought. */
std::string advice_text(const stability_advice &advice);

} // namespace berth

#endif
