#include "unseen_stretches.h"

#include <algorithm>

#include "../decide/stretches.h"

namespace berth
{

void add_stretches(cause_evidence &made, block_model &model, row_use use, const two_rigs &rigs, double noise_rms,
                   std::size_t stretches)
{
    std::vector<double> with;
    std::vector<double> without;
    model.error(rigs.with, with);
    model.error(rigs.without, without);
    std::vector<double> change(with.size());
    std::vector<bool> counts(with.size());
    for (std::size_t n = 0; n < with.size(); n++) {
        change[n] = (with[n] - without[n]) * (with[n] - without[n]);
        with[n] *= with[n];
        without[n] *= without[n];
        counts[n] = model.uses()[n] == use;
    }
    const auto sums = [&](const std::vector<double> &values) { return sums_by_stretch(values, counts, stretches); };
    const auto rows = static_cast<double>(std::count(counts.begin(), counts.end(), true));
    add_what_shows(made, {sums(with), sums(without), sums(change)},
                   noise_rms * noise_rms * rows / static_cast<double>(stretches));
}

} // namespace berth
