/* Setpoints lost among ringing traces, found by the sequential decoder: the truth is known. */
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

#include "../../firmware/pi.h"
#include "seeded.h"
#include "sim_hal/diagnosis/events.h"
#include "sim_hal/diagnosis/loss_decoder.h"

using namespace berth;

namespace
{

struct lossy {
    std::vector<double> sent;
    std::vector<std::uint8_t> lost;
    std::vector<double> error;
    std::vector<double> counts;
};

/* A force that rises within five ticks and rings for sixty. */
loss_trace ringing()
{
    loss_trace made{3, {}};
    for (int k = 0; k < 60; k++) {
        const double rise = 1.0 - std::exp(-0.5 * (k + 1));
        made.values.push_back(1e5 * rise * std::cos(0.8 * k) * std::exp(-0.06 * k));
    }
    return made;
}

lossy made_record(seeded::engine &random, const loss_trace &loss, double probability, double noise)
{
    constexpr std::size_t rows = 4000;
    lossy made{
        {}, std::vector<std::uint8_t>(rows, 0), std::vector<double>(rows, 0.0), std::vector<double>(rows, 1.0)};
    for (std::size_t n = 0; n < rows; n++) {
        const double t = 0.0025 * static_cast<double>(n);
        made.sent.push_back(0.01 * std::sin(two_pi * 0.7 * t) + 0.004 * std::sin(two_pi * 1.9 * t + 1.0));
        made.lost[n] = n > 0 && n + 100 < rows && seeded::uniform(random, 0.0, 1.0) < probability;
    }
    const std::vector<double> taken = taken_of(made.sent, made.lost);
    for (std::size_t n = 0; n < rows; n++) {
        made.error[n] += seeded::uniform(random, -noise, noise);
        for (std::size_t k = 0; k < loss.values.size() && n + loss.first + k < rows; k++) {
            made.error[n + loss.first + k] += (made.sent[n] - taken[n]) * loss.values[k];
        }
    }
    return made;
}

} // namespace

TEST_CASE("loss decoder: one setpoint in nine lost, each ringing into the next ones, is told for each of them")
{
    SEEDED(random, "loss decoder: one setpoint*");
    const loss_trace loss = ringing();
    for (const double probability : {0.002, 0.11, 0.2}) {
        CAPTURE(probability);
        const lossy record = made_record(random, loss, probability, 0.2);
        const decoded_losses found = decode_losses(record.sent, loss, record.error, record.counts, 24.0 * 0.013);
        std::size_t wrong = 0;
        double largest_m = 0.0; /* way of those that are wrong: at a turn the loss of one does nothing */
        const std::vector<double> taken = taken_of(record.sent, record.lost);
        const std::vector<double> told = taken_of(record.sent, found.lost);
        for (std::size_t n = 0; n < record.sent.size(); n++) {
            wrong += found.lost[n] != record.lost[n];
            largest_m = std::max(largest_m, std::abs(taken[n] - told[n]));
        }
        CHECK(wrong <= 40); /* of 4000 */
        CHECK(largest_m < 2e-5);
        double square = 0.0;
        for (const double rest : found.rest) {
            square += rest * rest;
        }
        CHECK(std::sqrt(square / 4000.0) < 1.1 * 0.2 / std::sqrt(3.0));
    }
}

TEST_CASE("loss decoder: noise alone is no loss, and rows that do not count decide nothing")
{
    SEEDED(random, "loss decoder: noise alone*");
    const loss_trace loss = ringing();
    const lossy quiet = made_record(random, loss, 0.0, 0.2);
    CHECK(count_of(decode_losses(quiet.sent, loss, quiet.error, quiet.counts, 24.0 * 0.013).lost) == 0);
    lossy unseen = made_record(random, loss, 0.1, 0.2);
    std::fill(unseen.counts.begin(), unseen.counts.end(), 0.0);
    CHECK(count_of(decode_losses(unseen.sent, loss, unseen.error, unseen.counts, 1.0).lost) == 0);
    CHECK(decode_losses({}, loss, {}, {}, 1.0).lost.empty());
}
