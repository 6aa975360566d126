#include "loss_finder.h"

#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "events.h"
#include "loss_decoder.h"

namespace berth
{

namespace
{

double counted_squares(const std::vector<double> &rest, const std::vector<double> &counts)
{
    double sum = 0.0;
    for (std::size_t n = 0; n < rest.size(); n++) {
        sum += counts[n] * rest[n] * rest[n];
    }
    return sum;
}

} // namespace

loss_finder::loss_finder(const block_model &model, const rig &rig, const loss_trace &loss,
                         const std::vector<double> &error, const std::vector<std::uint8_t> &known, std::size_t tries)
    : model_(model), path_(rig, model.data()), loss_(loss), error_(error), known_(known), tries_(tries),
      none_(model, loss, error, known, std::vector<std::uint8_t>(error.size(), 0))
{
}

void loss_finder::settle(std::vector<std::uint8_t> guess, double left_max)
{
    loss_settler settler(model_, loss_, error_, known_, std::move(guess));
    settler.settle(least(settler.lost));
    square_ = settler.square();
    lost = settler.lost;
    /* Losses whose traces ring into each other hide one another: half explained, and what is left is no noise.
     */
    constexpr double promising = 0.7;
    constexpr double spiky = 1.5;
    const double sigma = sigma_of(settler.rest(), model_.uses());
    if (square_ < promising * none_.square() && square_ > spiky * sigma * sigma * rows_compared()) {
        decode(left_max);
    }
}

void loss_finder::decode(double left_max)
{
    decode(error_.size(), left_max);
}

void loss_finder::decode_first(std::size_t ticks)
{
    decode(ticks, unlimited);
}

void loss_finder::decode(std::size_t ticks, double left_max)
{
    const auto first_of = [&](const std::vector<double> &all) {
        return std::vector<double>(all.begin(),
                                   all.begin() + static_cast<std::ptrdiff_t>(std::min(ticks, all.size())));
    };
    const std::vector<double> sent = first_of(model_.data().command_position_m);
    const std::vector<double> error = first_of(none_.rest());
    const std::vector<double> counts = first_of(none_.counts());
    const double square_max = left_max * none_.square();
    double penalty = 0.0; /* at first whatever it takes, to see how much noise there is at least */
    std::optional<decoded_losses> found = decode_losses(sent, path_, loss_, error, counts, penalty, square_max);
    if (!found) { /* or what it takes beside as much noise as may be left: fewer histories are worth keeping */
        penalty = least(std::vector<std::uint8_t>(sent.size(), 0)) * square_max / rows_compared();
        found = decode_losses(sent, path_, loss_, error, counts, penalty, square_max);
    }
    if (!found) {
        return;
    }
    constexpr int refinements = 2;
    for (int pass = 0; pass < refinements; pass++) {
        const double sigma = sigma_of(found->rest, model_.uses());
        penalty = least(found->lost) * sigma * sigma;
        found = decode_losses(sent, path_, loss_, error, counts, penalty, unlimited);
    }
    penalty_ = penalty;
    if (lost.empty() || cost_of(found->rest, found->lost) < cost()) {
        square_ = counted_squares(found->rest, none_.counts());
        sigma_ = sigma_of(found->rest, model_.uses());
        lost = std::move(found->lost);
        is_decoded = true;
    }
}

double loss_finder::cost_of(const std::vector<double> &rest, const std::vector<std::uint8_t> &rows) const
{
    return counted_squares(rest, none_.counts()) + penalty_ * static_cast<double>(count_of(rows));
}

double loss_finder::rows_compared() const
{
    return std::accumulate(none_.counts().begin(), none_.counts().end(), 0.0);
}

double loss_finder::information() const
{
    return rows_compared() * std::log(square_) + least(lost) * static_cast<double>(count_of(lost));
}

double loss_finder::least(const std::vector<std::uint8_t> &rows) const
{
    constexpr double sure = 6.0; /* logarithm of the odds */
    const auto candidates = static_cast<double>(tries_ == 0 ? rows.size() : tries_);
    return 2.0 * (std::log(std::max(1.0, candidates / static_cast<double>(count_of(rows) + 1))) + sure);
}

} // namespace berth
