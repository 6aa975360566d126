#include "stretches.h"

#include <algorithm>
#include <numeric>

namespace berth
{

std::vector<double> sums_by_stretch(const std::vector<double> &values, const std::vector<bool> &counts,
                                    std::size_t stretches)
{
    const auto rows = static_cast<std::size_t>(std::count(counts.begin(), counts.end(), true));
    std::vector<double> sums(stretches, 0.0);
    std::size_t row = 0;
    for (std::size_t n = 0; n < counts.size(); n++) {
        if (counts[n]) {
            sums[row * stretches / rows] += values[n];
            row++;
        }
    }
    return sums;
}

void add_what_shows(cause_evidence &made, const compared_stretches &all, double noise)
{
    constexpr double hardly = 0.1; /* of what it does in a stretch on average */
    const double sum = std::accumulate(all.change.begin(), all.change.end(), 0.0);
    const double least = std::min(noise, hardly * sum / static_cast<double>(all.change.size()));
    for (std::size_t i = 0; i < all.change.size(); i++) {
        if (all.change[i] > least) {
            made.unseen_with.push_back(all.with[i]);
            made.unseen_without.push_back(all.without[i]);
        }
    }
}

} // namespace berth
