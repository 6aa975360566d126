/* Setpoints lost among ringing traces, found by the sequential decoder: the truth is known. */
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <utility>
#include <vector>

#include "../../firmware/pi.h"
#include "hal/rig/rig_file.h"
#include "seeded.h"
#include "sim_hal/diagnosis/replay/driven_path.h"
#include "sim_hal/diagnosis/samples/events.h"
#include "sim_hal/diagnosis/samples/loss_decoder.h"

using namespace berth;

namespace
{

struct lossy {
    record data;
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

lossy made_record(seeded::engine &random, const rig &rig, const loss_trace &loss, double probability, double noise)
{
    constexpr std::size_t rows = 4000;
    lossy made{
        {}, {}, std::vector<std::uint8_t>(rows, 0), std::vector<double>(rows, 0.0), std::vector<double>(rows, 1.0)};
    made.data.period_s = config_period_s(&rig.firmware);
    for (std::size_t n = 0; n < rows; n++) {
        const double t = 0.0025 * static_cast<double>(n);
        made.data.time_s.push_back(t);
        made.sent.push_back(0.01 * std::sin(two_pi * 0.7 * t) + 0.004 * std::sin(two_pi * 1.9 * t + 1.0));
        made.lost[n] = n > 0 && n + 100 < rows && seeded::uniform(random, 0.0, 1.0) < probability;
    }
    made.data.command_position_m = made.sent;
    made.data.segments.push_back({0, rows, {}});
    const std::vector<double> lacked_m = way_lacked_m(rig, made.data, made.lost);
    for (std::size_t n = 0; n < rows; n++) {
        made.error[n] += seeded::uniform(random, -noise, noise);
        for (std::size_t k = 0; k < loss.values.size() && n + loss.first + k < rows; k++) {
            made.error[n + loss.first + k] += lacked_m[n] * loss.values[k];
        }
    }
    return made;
}

decoded_losses decoded(const rig &rig, const loss_trace &loss, const lossy &record, double penalty)
{
    return *decode_losses(record.sent, driven_path(rig, record.data), loss, record.error, record.counts, penalty,
                          unlimited);
}

double rms_of(const std::vector<double> &values)
{
    double square = 0.0;
    for (const double value : values) {
        square += value * value;
    }
    return std::sqrt(square / static_cast<double>(values.size()));
}

} // namespace

TEST_CASE("loss decoder: one setpoint in nine lost, each ringing into the next ones, is told for each of them")
{
    SEEDED(random, "loss decoder: one setpoint*");
    const loss_trace loss = ringing();
    for (const double probability : {0.002, 0.11, 0.2}) {
        CAPTURE(probability);
        const rig rig = load_rig("ess", {});
        const lossy record = made_record(random, rig, loss, probability, 0.2);
        const decoded_losses found = decoded(rig, loss, record, 24.0 * 0.013);
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
        CHECK(rms_of(found.rest) < 1.1 * 0.2 / std::sqrt(3.0));
    }
}

TEST_CASE("loss decoder: what acts on the way of the setpoints is carried along each history")
{
    SEEDED(random, "loss decoder: what acts*");
    const loss_trace loss = ringing();
    const double noise = 0.2 / std::sqrt(3.0);
    /* Two losses in a row of which the first does nothing at once are not told: some of what a limit hides stays. */
    const std::vector<std::pair<std::string, double>> left_at_most = {
        {"robot.deadband_m=2e-4", 1.1 * noise}, {"robot.velocity_limit_m_per_s=0.05", 4.0 * noise}};
    for (const auto &one : left_at_most) {
        const std::string &acts = one.first;
        CAPTURE(acts);
        const rig rig = load_rig("ess", {acts});
        const lossy record = made_record(random, rig, loss, 0.05, 0.2);
        REQUIRE(rms_of(record.error) > 15.0 * noise);
        const double left = rms_of(decoded(rig, loss, record, 24.0 * 0.013).rest);
        CHECK(left < one.second);
        CHECK(rms_of(decoded(load_rig("ess", {}), loss, record, 24.0 * 0.013).rest) >
              2.0 * left); /* as if nothing did */
    }
}

TEST_CASE("loss decoder: noise alone is no loss, and rows that do not count decide nothing")
{
    SEEDED(random, "loss decoder: noise alone*");
    const loss_trace loss = ringing();
    const rig rig = load_rig("ess", {});
    const lossy quiet = made_record(random, rig, loss, 0.0, 0.2);
    CHECK(count_of(decoded(rig, loss, quiet, 24.0 * 0.013).lost) == 0);
    lossy unseen = made_record(random, rig, loss, 0.1, 0.2);
    std::fill(unseen.counts.begin(), unseen.counts.end(), 0.0);
    CHECK(count_of(decoded(rig, loss, unseen, 1.0).lost) == 0);
    CHECK(decode_losses({}, driven_path(rig, quiet.data), loss, {}, {}, 1.0, unlimited)->lost.empty());
}

TEST_CASE("loss decoder: it gives up where any losses would leave more than they may, whatever they have to explain")
{
    SEEDED(random, "loss decoder: it gives up*");
    const loss_trace loss = ringing();
    const rig rig = load_rig("ess", {});
    const lossy record = made_record(random, rig, loss, 0.1, 0.2);
    for (const double penalty : {0.0, 24.0 * 0.013}) {
        CAPTURE(penalty);
        const std::vector<double> rest = decoded(rig, loss, record, penalty).rest;
        const double least = std::pow(rms_of(rest), 2) * static_cast<double>(rest.size());
        const auto is_decoded_within = [&](double square_max) {
            const driven_path path(rig, record.data);
            return decode_losses(record.sent, path, loss, record.error, record.counts, penalty, square_max)
                .has_value();
        };
        CHECK(is_decoded_within(least));
        CHECK_FALSE(is_decoded_within(0.9 * least));
    }
}
