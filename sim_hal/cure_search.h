/* The smallest change of one parameter that makes an unstable loop stable, for loops whose limits no equation tells:
 * loops that change from tick to tick or on schedule, arms, and compensations. */
#ifndef SIM_HAL_CURE_SEARCH_H
#define SIM_HAL_CURE_SEARCH_H

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "../hal/rig/rig.h"
#include "prediction.h"

namespace berth
{

/* The rig with another value of a key, as --set makes it; nothing where no rig file may have it. */
std::optional<rig> with_setting(const rig &original, std::string_view key, double value);

/* Rounded to so many digits, away from the value that it comes from. */
double rounded_beyond(double value, double own, int digits);

/* A change that has been tried out. */
struct parameter_cure {
    std::string key;
    double own;          /* the rig's own value */
    double value;        /* with which the loop is stable */
    double growth_per_s; /* then */
};

/* Beyond the value that is printed, a cure is predicted at these shares of it again: no sliver is advised. */
constexpr double cure_safety[] = {0.02, 0.05};

/* Nothing where `predict` does not call the loop stable with it, and cure_safety further. */
std::optional<parameter_cure> tried_cure(const rig &original, std::string_view key, double value,
                                         const growth_predictor &predict);

/* Keys whose values may cure the loop: masses, springs, dampers and delays, and the sizes of what changes it. */
std::vector<std::string_view> curing_keys(const rig &rig);

/* The nearest cure by factor, up to 10 either way, in steps of 5 % at first and of 40 % in the end: a narrower
 * stable interval may be overlooked. `guess` may be rough and has to be fast; `predict` decides. */
std::optional<parameter_cure> nearest_cure(const rig &rig, const growth_predictor &guess,
                                           const growth_predictor &predict);

} // namespace berth

#endif
