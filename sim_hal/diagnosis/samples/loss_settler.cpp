#include "loss_settler.h"

#include <algorithm>
#include <cmath>

#include "../noise/noise.h"

namespace berth
{

namespace
{

constexpr std::size_t run_max = losses_in_a_row_max;
constexpr std::size_t apart_max = 3; /* of two that are looked at together, one less */
constexpr std::size_t seen_min = 6;  /* ticks of what it does before the record ends */
/* Setpoints of which every combination is tried: among fewer, one that is wrong may help as well. */
constexpr std::size_t window = 12;
constexpr int bursts_max = 2000; /* in which every combination is tried: more are no lost setpoints */

} // namespace

double sigma_of(const std::vector<double> &error, const std::vector<row_use> &uses)
{
    std::vector<double> sizes;
    for (std::size_t n = 0; n < error.size(); n++) {
        if (uses[n] != row_use::none) {
            sizes.push_back(std::abs(error[n]));
        }
    }
    return 1.4826 * median_of(sizes);
}

std::vector<double> taken_of(const std::vector<double> &sent, const std::vector<std::uint8_t> &lost)
{
    std::vector<double> taken = sent;
    for (std::size_t n = 1; n < taken.size(); n++) {
        taken[n] = lost[n] != 0 ? taken[n - 1] : sent[n];
    }
    return taken;
}

loss_settler::loss_settler(const block_model &model, const loss_trace &loss, const std::vector<double> &error,
                           const std::vector<std::uint8_t> &known, std::vector<std::uint8_t> first_guess)
    : lost(std::move(first_guess)), model_(model), loss_(loss), sent_(model.data().command_position_m), rest_(error),
      end_(sent_.size() - std::min(sent_.size(), loss.first + seen_min))
{
    for (const row_use use : model.uses()) {
        counts_.push_back(use == row_use::none ? 0.0 : 1.0);
    }
    taken_ = taken_of(sent_, known);
    const std::vector<double> taken = taken_of(sent_, lost);
    for (std::size_t n = 0; n < end_; n++) {
        put(n, taken[n]);
    }
}

void loss_settler::settle(double least)
{
    constexpr int rounds = 8;
    largest_of helps(end_ * apart_max);
    for (int round = 0; round < rounds; round++) {
        const double sigma = sigma_of(rest_, model_.uses());
        const double least_square = least * sigma * sigma;
        bool any = take_best_first(helps, least_square);
        any = search_bursts(least_square) || any;
        if (!any) {
            break;
        }
    }
}

double loss_settler::square(std::size_t begin, std::size_t end) const
{
    double sum = 0.0;
    for (std::size_t row = begin; row < std::min(end, rest_.size()); row++) {
        sum += counts_[row] * rest_[row] * rest_[row];
    }
    return sum;
}

bool loss_settler::take_best_first(largest_of &helps, double least)
{
    if (end_ <= 1) {
        return false;
    }
    find_help(helps, 1, end_, least);
    std::size_t best = helps.place();
    const bool any = helps[best] > 0.0;
    for (std::size_t i = 0; i < 2 * end_ && helps[best] > 0.0; i++) {
        const std::size_t n = best / apart_max;
        flip(n, n + best % apart_max);
        const std::size_t reach = loss_.first + loss_.values.size() + 2 * run_max;
        find_help(helps, n > reach ? n - reach : 1, std::min(end_, n + reach), least);
        best = helps.place();
    }
    return any;
}

bool loss_settler::search_bursts(double least)
{
    constexpr std::size_t before = 3;
    constexpr double far = 4.0;  /* times what one loss has to explain */
    constexpr double rise = 0.2; /* of it may have been there before */
    bool any = false;
    int tried = 0;
    for (std::size_t n = 1 + before; n + window < end_ && tried < bursts_max; n++) {
        const std::size_t from = n + loss_.first;
        const double begins = square(from, from + before);
        if (begins > far * least && square(from - before, from) < rise * begins) {
            any = try_all(n - before, least) || any;
            tried++;
        }
    }
    return any;
}

bool loss_settler::try_all(std::size_t from, double least)
{
    const auto count = [&] {
        return std::count(lost.begin() + static_cast<std::ptrdiff_t>(from),
                          lost.begin() + static_cast<std::ptrdiff_t>(from + window), std::uint8_t{1});
    };
    const auto count_before = count();
    double most = 0.0;
    unsigned best = 0;
    changed_ = 0.0;
    for (unsigned i = 1; i < 1U << window; i++) { /* Gray's code: from one combination to the next by one flip */
        flip_one_of(from, i);
        if (-changed_ <= most) {
            continue;
        }
        const auto more = static_cast<double>(count() - count_before);
        const double help = -changed_ - least * std::max(0.0, more);
        if (help > most && longest_run(from, from + window) <= run_max) {
            most = help;
            best = i ^ (i >> 1U);
        }
    }
    flip_one_of(from, 1U << (window - 1)); /* the last one is the first bit alone */
    for (std::size_t bit = 0; bit < window; bit++) {
        if ((best >> bit & 1U) != 0) {
            flip(from + bit, from + bit);
        }
    }
    return best != 0;
}

void loss_settler::flip_one_of(std::size_t from, unsigned i)
{
    std::size_t bit = 0;
    while ((i >> bit & 1U) == 0) {
        bit++;
    }
    flip(from + bit, from + bit);
}

void loss_settler::find_help(largest_of &helps, std::size_t from, std::size_t to, double least)
{
    helps.renew(from * apart_max, to * apart_max, [&](std::size_t i) {
        const std::size_t n = i / apart_max;
        return n + apart_max < end_ ? help_of(n, n + i % apart_max, least) : 0.0;
    });
}

double loss_settler::help_of(std::size_t first, std::size_t second, double least)
{
    const int more = (lost[first] == 0 ? 1 : -1) + (second == first ? 0 : lost[second] == 0 ? 1 : -1);
    changed_ = 0.0;
    const std::size_t last = flip(first, second);
    const bool is_possible = more <= 0 || longest_run(first, last) <= run_max;
    const double help = is_possible ? -changed_ - least * std::max(0, more) : 0.0;
    flip(first, second);
    return help;
}

std::size_t loss_settler::flip(std::size_t first, std::size_t second)
{
    lost[first] = lost[first] == 0;
    lost[second] = second == first ? lost[second] : lost[second] == 0;
    std::size_t last = second + 1;
    while (last < end_ && lost[last] != 0) {
        last++;
    }
    double standing = taken_[first - 1];
    for (std::size_t n = first; n < last; n++) {
        standing = lost[n] != 0 ? standing : sent_[n];
        put(n, standing);
    }
    return last;
}

std::size_t loss_settler::longest_run(std::size_t first, std::size_t last) const
{
    while (first > 0 && lost[first - 1] != 0) {
        first--;
    }
    std::size_t longest = 0;
    std::size_t run = 0;
    for (std::size_t n = first; n < last; n++) {
        run = lost[n] != 0 ? run + 1 : 0;
        longest = std::max(longest, run);
    }
    return longest;
}

void loss_settler::put(std::size_t n, double taken)
{
    const double way = taken_[n] - taken;
    if (way == 0.0) {
        return;
    }
    const std::size_t seen = std::min(loss_.values.size(), rest_.size() - (n + loss_.first));
    double *const rest = &rest_[n + loss_.first];
    const double *const counts = &counts_[n + loss_.first];
    for (std::size_t k = 0; k < seen; k++) {
        const double before = rest[k];
        rest[k] -= way * loss_.values[k];
        changed_ += counts[k] * (rest[k] - before) * (rest[k] + before);
    }
    taken_[n] = taken;
}

} // namespace berth
