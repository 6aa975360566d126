#include "tendency.h"

#include <algorithm>
#include <cmath>

namespace berth
{

namespace
{

tendency tendency_of(double growth_per_s, double ci95_per_s)
{
    if (!(std::abs(growth_per_s) > std::max(ci95_per_s, 0.0))) {
        return tendency::unknown;
    }
    return growth_per_s < 0.0 ? tendency::decays : tendency::grows;
}

tendency tendency_of(const std::optional<bool> &decays)
{
    return !decays ? tendency::unknown : *decays ? tendency::decays : tendency::grows;
}

} // namespace

tendency held_tendency_of(const growth_prediction &prediction)
{
    return tendency_of(is_stable_in_contact(prediction));
}

tendency tendency_of(const growth_prediction &prediction)
{
    return tendency_of(is_stable(prediction));
}

tendency tendency_of(const motion_evidence &motion)
{
    return motion.growth && !motion.is_driven
               ? tendency_of(motion.growth->growth_per_s, motion.growth->growth_ci95_per_s)
               : tendency::unknown;
}

} // namespace berth
