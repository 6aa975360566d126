#include "recommendation.h"

#include "../hal/rig/keys.h"
#include "../hal/rig/rig_file.h"
#include "compensated.h"

namespace berth
{

namespace
{

/* A robust method whose motion is further from the truth than this is none that one would want. */
constexpr double useful_error = 0.5;

bool is_useful(const method_verdict &verdict)
{
    return verdict.worst_error <= useful_error;
}

} // namespace

std::optional<std::string> why_unsafe(const rig &original, const std::vector<std::string> &settings)
{
    rig with = original;
    for (const std::string &setting : settings) {
        const std::size_t equals = setting.find('=');
        if (const auto error = set_value(with, setting.substr(0, equals), setting.substr(equals + 1))) {
            throw input_error(error->key + ": " + error->message);
        }
    }
    if (const auto error = complete_and_check(with)) {
        throw input_error(error->key + ": " + error->message);
    }
    const compensated_growth found = growth_of_compensated(with);
    return found.is_stable() ? std::nullopt : std::optional(found.verdict.because);
}

recommendation recommend(const choice &made, const rig &rig)
{
    recommendation found;
    for (const method_verdict &verdict : made.methods) {
        if (!verdict.is_robust || !is_useful(verdict)) {
            break; /* so are all that follow */
        }
        const auto because = why_unsafe(rig, verdict.method.settings);
        if (!because) {
            found.best = &verdict;
            break;
        }
        found.passed_over.push_back({verdict.method.name, *because});
    }
    return found;
}

} // namespace berth
