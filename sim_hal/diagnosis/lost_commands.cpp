#include "lost_commands.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "loss_decoder.h"
#include "loss_settler.h"

namespace berth
{

namespace
{

loss_trace trace_of_loss(block_model &model, const rig &rig)
{
    const record &record = model.data();
    const double span_s = 1e-3 * rig.robot.dead_time_ms + 1e-9 * static_cast<double>(sync_wait_ns(rig)) +
                          1e-3 * rig.sensor.delay_ms + 0.15;
    const auto span = static_cast<std::size_t>(span_s / record.period_s) + 4;
    std::size_t at = 0;
    double way = 0.0;
    for (std::size_t n = span; n + 2 * span < record.size(); n++) {
        const double step = std::abs(record.command_position_m[n] - record.command_position_m[n - 1]);
        if (step > way) {
            way = step;
            at = n;
        }
    }
    loss_trace made{0, {}};
    if (way == 0.0) {
        return made;
    }
    sample_events one;
    one.lost_command.assign(record.size(), 0);
    one.lost_command[at] = 1;
    std::vector<double> with;
    std::vector<double> without;
    block_model other(model.which(), record, rig, one, held_out_parts::none);
    const sample_events none;
    block_model plain(model.which(), record, rig, none, held_out_parts::none);
    other.error(rig, with);
    plain.error(rig, without);
    const double lacked = record.command_position_m[at] - record.command_position_m[at - 1];
    double largest = 0.0;
    for (std::size_t k = 0; k < span; k++) {
        made.values.push_back((without[at + k] - with[at + k]) / lacked);
        largest = std::max(largest, std::abs(made.values.back()));
    }
    while (!made.values.empty() && std::abs(made.values.back()) < 0.02 * largest) {
        made.values.pop_back();
    }
    while (!made.values.empty() && std::abs(made.values.front()) < 0.02 * largest) {
        made.values.erase(made.values.begin());
        made.first++;
    }
    for (const double value : made.values) {
        made.square += value * value;
    }
    return made;
}

/* Chance does not care how far a setpoint leads: where nearly only the smallest steps are missing, it is a
 * threshold. */
bool are_the_smallest(const std::vector<double> &sent, const std::vector<std::uint8_t> &lost)
{
    const std::vector<double> taken = taken_of(sent, lost);
    std::vector<double> missing;
    std::vector<double> done;
    for (std::size_t n = 1; n < sent.size(); n++) {
        (lost[n] != 0 ? missing : done).push_back(std::abs(sent[n] - taken[n - 1]));
    }
    if (missing.empty() || done.empty()) {
        return false;
    }
    constexpr double most = 0.95;
    const auto at = missing.begin() + static_cast<std::ptrdiff_t>(most * static_cast<double>(missing.size() - 1));
    std::nth_element(missing.begin(), at, missing.end());
    const double way = *at;
    const auto smaller = std::count_if(done.begin(), done.end(), [&](double step) { return step < way; });
    return 2 * static_cast<std::size_t>(smaller) < done.size();
}

struct losses {
    std::vector<std::uint8_t> rows;
    double share_left; /* of the squares without any */
};

double sum_of_squares(const std::vector<double> &rest, const std::vector<double> &counts)
{
    double sum = 0.0;
    for (std::size_t n = 0; n < rest.size(); n++) {
        sum += counts[n] * rest[n] * rest[n];
    }
    return sum;
}

/* From a first guess to all that the error shows. `tries`: setpoints whose loss would be clear. */
losses settled(const block_model &model, const loss_trace &loss, const std::vector<double> &error,
               const std::vector<std::uint8_t> &known, std::vector<std::uint8_t> guess, std::size_t tries)
{
    constexpr double sure = 6.0; /* logarithm of the odds */
    /* Where one in eight is lost, less has to speak for it than where one in a thousand is. */
    const auto least = [&](const std::vector<std::uint8_t> &lost) {
        const auto candidates = static_cast<double>(tries == 0 ? lost.size() : tries);
        return 2.0 * (std::log(std::max(1.0, candidates / static_cast<double>(count_of(lost) + 1))) + sure);
    };
    const loss_settler none(model, loss, error, known, std::vector<std::uint8_t>(error.size(), 0));
    loss_settler settler(model, loss, error, known, std::move(guess));
    settler.settle(least(settler.lost));
    double square = settler.square();
    losses found{settler.lost, 1.0};

    /* Losses whose traces ring into each other hide one another: half explained, and what is left is no noise. */
    constexpr double promising = 0.7;
    constexpr double spiky = 1.5;
    const double sigma_left = sigma_of(settler.rest(), model.uses());
    const double rows = std::accumulate(none.counts().begin(), none.counts().end(), 0.0);
    if (square < promising * none.square() && square > spiky * sigma_left * sigma_left * rows) {
        double penalty = 0.0; /* at first whatever it takes, to see how much noise there is at least */
        decoded_losses decoded;
        for (int pass = 0; pass < 3; pass++) {
            decoded = decode_losses(model.data().command_position_m, loss, none.rest(), none.counts(), penalty);
            const double sigma = sigma_of(decoded.rest, model.uses());
            penalty = least(decoded.lost) * sigma * sigma;
        }
        const auto cost = [&](double left, const std::vector<std::uint8_t> &lost) {
            return left + penalty * static_cast<double>(count_of(lost));
        };
        const double square_decoded = sum_of_squares(decoded.rest, none.counts());
        if (cost(square_decoded, decoded.lost) < cost(square, found.rows)) {
            square = square_decoded;
            found.rows = std::move(decoded.lost);
        }
    }
    found.share_left = square / std::max(none.square(), 1e-300);
    return found;
}

} // namespace

bool force_knows_of(block_model &force, const rig &rig, const sample_events &events)
{
    const loss_trace loss = trace_of_loss(force, rig);
    std::vector<double> error;
    force.error(rig, error);
    const record &record = force.data();
    /* A grip that has given way feels nothing, and otherwise than this model after it: it is not asked. */
    constexpr double held_share = 0.75;
    const double least_N = 0.1 * rms_of(record.force_N, force.uses(), row_use::fit);
    std::vector<double> shares;
    std::size_t held = 0;
    for (std::size_t n = 1; n + loss.first + loss.values.size() < record.size() && !loss.values.empty(); n++) {
        if (events.lost_command[n] != 0) {
            const double way = record.command_position_m[n] - record.command_position_m[n - 1];
            double sum = 0.0;
            double largest_N = 0.0;
            for (std::size_t k = 0; k < loss.values.size(); k++) {
                sum += loss.values[k] * error[n + loss.first + k];
                largest_N = std::max(largest_N, std::abs(record.force_N[n + loss.first + k]));
            }
            shares.push_back(sum / (way * loss.square));
            held += largest_N > least_N;
        }
    }
    return median_of(shares) > 0.5 || static_cast<double>(held) < held_share * static_cast<double>(shares.size());
}

std::vector<event_finding> find_lost_commands(block_model &model, const rig &rig, const std::vector<double> &error,
                                              sample_events &events, double left_max)
{
    constexpr double like = 0.75;      /* share of a loss that the error must show */
    const record &record = model.data();
    const loss_trace loss = trace_of_loss(model, rig);
    if (loss.values.empty()) {
        return {};
    }
    const double sigma = sigma_of(error, model.uses());
    const std::size_t length = loss.values.size();
    const auto way_of = [&](std::size_t n) {
        return record.command_position_m[n] - record.command_position_m[n - 1];
    };
    std::vector<std::size_t> rows;
    for (std::size_t n = 1; n + loss.first + length < record.size(); n++) {
        const std::size_t from = n + loss.first;
        if (std::abs(way_of(n)) * std::sqrt(loss.square) > loss_clear_sd * sigma &&
            model.uses()[from] != row_use::none && model.uses()[from + length - 1] != row_use::none) {
            rows.push_back(n);
        }
    }
    /* Share of the trace that the error shows from a setpoint on. */
    std::vector<double> rest = error;
    const auto share_at = [&](std::size_t n) {
        double sum = 0.0;
        for (std::size_t k = 0; k < length; k++) {
            sum += loss.values[k] * rest[n + loss.first + k];
        }
        return sum / (way_of(n) * loss.square);
    };
    std::vector<double> shares;
    shares.reserve(rows.size());
    for (const std::size_t n : rows) {
        shares.push_back(share_at(n));
    }
    const double usual = median_of(shares); /* a wrong dead time looks like a little of a loss at every setpoint */
    /* By how much the sum of squares falls if this setpoint was lost; only where it looks like one. */
    const auto promise_of = [&](std::size_t i) {
        const double share = shares[i] - usual;
        const double way = way_of(rows[i]);
        return share > like ? (2.0 * share - 1.0) * way * way : 0.0;
    };
    std::vector<double> promises(rows.size());
    for (std::size_t i = 0; i < rows.size(); i++) {
        promises[i] = promise_of(i);
    }
    std::vector<std::uint8_t> lost(error.size(), 0);
    std::size_t hits = 0;
    while (hits * 4 <= rows.size()) { /* the clearest one first; it is taken out before the next one is looked for */
        const auto best = std::max_element(promises.begin(), promises.end());
        if (best == promises.end() || *best <= 0.0) {
            break;
        }
        const std::size_t n = rows[static_cast<std::size_t>(best - promises.begin())];
        for (std::size_t k = 0; k < length; k++) {
            rest[n + loss.first + k] -= way_of(n) * loss.values[k];
        }
        lost[n] = 1;
        hits++;
        const auto begin = std::lower_bound(rows.begin(), rows.end(), n > length ? n - length : 0) - rows.begin();
        for (auto i = static_cast<std::size_t>(begin); i < rows.size() && rows[i] < n + length; i++) {
            shares[i] = share_at(rows[i]);
            promises[i] = lost[rows[i]] != 0 ? 0.0 : promise_of(i);
        }
    }
    std::size_t counter_hits = 0; /* the opposite of a loss: there is no such thing */
    for (const double share : shares) {
        counter_hits += share - usual < -like;
    }
    const bool are_clear = hits >= events_min && counter_hits * 4 <= hits && hits * 4 <= rows.size();
    std::vector<std::uint8_t> known = events.lost_command;
    known.resize(lost.size(), 0);
    for (std::size_t n = 0; n < lost.size(); n++) {
        lost[n] = known[n] != 0 || (lost[n] != 0 && are_clear);
    }
    const losses all_lost = settled(model, loss, error, known, std::move(lost), rows.size());
    const bool explain_most = all_lost.share_left < left_max && count_of(all_lost.rows) >= events_min;
    const bool are_some = are_clear || count_of(known) > 0 || explain_most;
    const bool is_new = count_of(known) == 0;
    if (!are_some || all_lost.rows == known || (is_new && 4 * count_of(all_lost.rows) > error.size()) ||
        (is_new && are_the_smallest(record.command_position_m, all_lost.rows))) {
        return {};
    }
    events.lost_command = all_lost.rows;
    std::size_t all = 0; /* with those that another channel has shown */
    for (const std::size_t n : rows) {
        all += events.lost_command[n] != 0;
    }
    return {found_in("robot.lost_commands", all, rows.size())};
}

} // namespace berth
