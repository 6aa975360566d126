#include "printable.h"

#include <random>

#include "criteria.h"

namespace berth
{

double share_of_draws_that_gain(const cause_evidence &cause)
{
    constexpr int draws = 1000;
    const std::size_t stretches = cause.unseen_with.size();
    if (stretches == 0) {
        return 1.0;
    }
    std::minstd_rand random(1);
    std::uniform_int_distribution<std::size_t> any(0, stretches - 1);
    int falls = 0;
    for (int draw = 0; draw < draws; draw++) {
        double gain = 0.0;
        for (std::size_t i = 0; i < stretches; i++) {
            const std::size_t at = any(random);
            gain += cause.unseen_without[at] - cause.unseen_with[at];
        }
        falls += gain > 0.0;
    }
    return static_cast<double>(falls) / draws;
}

const char *why_not_printable(const cause_evidence &cause)
{
    if (cause.share_explained < criteria::share_explained_least) {
        return "explains nothing to speak of";
    }
    if (cause.may_be_none) {
        return "may have no size at all";
    }
    if (share_of_draws_that_gain(cause) < criteria::share_of_draws_least) {
        return "does not predict unseen data better";
    }
    return nullptr;
}

} // namespace berth
