/* Which of the methods that were tried is worth having: robust, useful, and stable by every other answer too. */
#ifndef SIM_HAL_RECOMMENDATION_H
#define SIM_HAL_RECOMMENDATION_H

#include <optional>
#include <string>
#include <vector>

#include "compensation/chooser.h"

namespace berth
{

struct unsafe_method {
    std::string name;
    std::string because;
};

struct recommendation {
    const method_verdict *best = nullptr; /* of those that are robust, useful and safe; none: null */
    std::vector<unsafe_method> passed_over;
};

recommendation recommend(const choice &made, const rig &rig);

/* Why the rig with these settings is not stable; nothing: it is. A tool in contact is held to the material there,
 * which no trial does. Throws input_error. */
std::optional<std::string> why_unsafe(const rig &original, const std::vector<std::string> &settings);

} // namespace berth

#endif
