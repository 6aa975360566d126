#include "printable.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "criteria.h"

namespace berth
{

namespace
{

constexpr int draws = 1000;

/* From the smallest to the largest; none without stretches. */
std::vector<double> gains_of_draws(const cause_evidence &cause)
{
    const std::size_t stretches = cause.unseen_with.size();
    std::vector<double> gains;
    if (stretches == 0) {
        return gains;
    }
    std::minstd_rand random(1);
    std::uniform_int_distribution<std::size_t> any(0, stretches - 1);
    for (int draw = 0; draw < draws; draw++) {
        double with = 0.0;
        double without = 0.0;
        for (std::size_t i = 0; i < stretches; i++) {
            const std::size_t at = any(random);
            with += cause.unseen_with[at];
            without += cause.unseen_without[at];
        }
        gains.push_back(without > 0.0 ? 1.0 - with / without : 0.0);
    }
    std::sort(gains.begin(), gains.end());
    return gains;
}

} // namespace

unseen_gain gain_of(const cause_evidence &cause)
{
    const std::vector<double> gains = gains_of_draws(cause);
    if (gains.empty()) {
        return {0.0, 0.0, 0.0};
    }
    const double with = std::accumulate(cause.unseen_with.begin(), cause.unseen_with.end(), 0.0);
    const double without = std::accumulate(cause.unseen_without.begin(), cause.unseen_without.end(), 0.0);
    return {without > 0.0 ? 1.0 - with / without : 0.0, gains[draws / 40], gains[draws - 1 - draws / 40]};
}

double share_of_draws_that_gain(const cause_evidence &cause)
{
    const std::vector<double> gains = gains_of_draws(cause);
    const auto falls = std::count_if(gains.begin(), gains.end(), [](double gain) { return gain > 0.0; });
    return static_cast<double>(falls) / draws;
}

double probability_of(double delta_bic)
{
    return 1.0 / (1.0 + std::exp(-0.5 * delta_bic));
}

double probability_of(const cause_evidence &cause, double delta_bic)
{
    /* Of so many draws, all of which gain, one more may not. */
    const double of_draws = share_of_draws_that_gain(cause) * draws / (draws + 1.0);
    return std::min(of_draws, probability_of(delta_bic));
}

const char *why_not_printable(const cause_evidence &cause)
{
    if (!(cause.share_explained >= criteria::share_explained_least)) {
        return "explains nothing to speak of";
    }
    if (cause.may_be_none) {
        return "may have no size at all";
    }
    if (cause.unseen_with.size() < criteria::stretches_least) {
        return "shows in too little of the unseen data";
    }
    if (share_of_draws_that_gain(cause) < criteria::share_of_draws_least) {
        return "does not predict unseen data better";
    }
    return nullptr;
}

const char *why_no_rival(const cause_evidence &rival)
{
    if (rival.may_be_none) {
        return "may have no size at all";
    }
    return gain_of(rival).value > 0.0 ? nullptr : "does not predict unseen data better";
}

} // namespace berth
