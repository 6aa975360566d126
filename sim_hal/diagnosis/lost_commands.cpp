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

double counted_squares(const std::vector<double> &rest, const std::vector<double> &counts)
{
    double sum = 0.0;
    for (std::size_t n = 0; n < rest.size(); n++) {
        sum += counts[n] * rest[n] * rest[n];
    }
    return sum;
}

/* From a first guess to all that the error shows. */
class loss_finder
{
  public:
    /* `tries`: setpoints whose loss would be clear. */
    loss_finder(const block_model &model, const loss_trace &loss, const std::vector<double> &error,
                const std::vector<std::uint8_t> &known, std::size_t tries)
        : model_(model), loss_(loss), error_(error), known_(known), tries_(tries),
          none_(model, loss, error, known, std::vector<std::uint8_t>(error.size(), 0))
    {
    }

    void find(std::vector<std::uint8_t> guess, bool decode_alone)
    {
        if (decode_alone) {
            decode();
            return;
        }
        loss_settler settler(model_, loss_, error_, known_, std::move(guess));
        settler.settle(least(settler.lost));
        square_ = settler.square();
        lost = settler.lost;
        /* Losses whose traces ring into each other hide one another: half explained, and what is left is no noise.
         */
        constexpr double promising = 0.7;
        constexpr double spiky = 1.5;
        const double sigma = sigma_of(settler.rest(), model_.uses());
        const double rows = std::accumulate(none_.counts().begin(), none_.counts().end(), 0.0);
        if (square_ < promising * none_.square() && square_ > spiky * sigma * sigma * rows) {
            decode();
        }
    }

    std::vector<std::uint8_t> lost;
    bool is_decoded = false;

    /* Of the squares that are there without any loss. */
    double share_left() const { return square_ / std::max(none_.square(), 1e-300); }

  private:
    /* Takes what it finds if that is better. */
    void decode()
    {
        double penalty = 0.0; /* at first whatever it takes, to see how much noise there is at least */
        decoded_losses found;
        for (int pass = 0; pass < 3; pass++) {
            found = decode_losses(model_.data().command_position_m, loss_, none_.rest(), none_.counts(), penalty);
            const double sigma = sigma_of(found.rest, model_.uses());
            penalty = least(found.lost) * sigma * sigma;
        }
        const auto cost = [&](double square, const std::vector<std::uint8_t> &rows) {
            return square + penalty * static_cast<double>(count_of(rows));
        };
        const double square = counted_squares(found.rest, none_.counts());
        if (lost.empty() || cost(square, found.lost) < cost(square_, lost)) {
            square_ = square;
            lost = std::move(found.lost);
            is_decoded = true;
        }
    }

    /* Squares of sigma that a loss has to explain: where one in eight is lost, less than where one in a thousand is.
     */
    double least(const std::vector<std::uint8_t> &rows) const
    {
        constexpr double sure = 6.0; /* logarithm of the odds */
        const auto candidates = static_cast<double>(tries_ == 0 ? rows.size() : tries_);
        return 2.0 * (std::log(std::max(1.0, candidates / static_cast<double>(count_of(rows) + 1))) + sure);
    }

    const block_model &model_;
    const loss_trace &loss_;
    const std::vector<double> &error_;
    const std::vector<std::uint8_t> &known_;
    std::size_t tries_;
    loss_settler none_;
    double square_ = 0.0;
};

} // namespace

bool force_knows_of(block_model &force, const rig &rig, const sample_events &events)
{
    const loss_trace loss = trace_of_loss(force, rig);
    std::vector<double> error;
    force.error(rig, error);
    const record &record = force.data();
    /* A grip that has given way feels nothing, and otherwise than this model after it: it is not asked. */
    constexpr double held_share = 0.5;
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
                                              sample_events &events, loss_search &search)
{
    constexpr double like = 0.75; /* share of a loss that the error must show */
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
    loss_finder finder(model, loss, error, known, rows.size());
    finder.find(std::move(lost), search.decode_alone);
    search.was_decoded = finder.is_decoded;
    const bool explain_most = finder.share_left() < search.left_max && count_of(finder.lost) >= events_min;
    const bool are_some = are_clear || count_of(known) > 0 || explain_most;
    const bool is_new = count_of(known) == 0;
    if (!are_some || finder.lost == known || (is_new && 4 * count_of(finder.lost) > error.size()) ||
        (is_new && are_the_smallest(record.command_position_m, finder.lost))) {
        return {};
    }
    events.lost_command = std::move(finder.lost);
    if (rows.empty()) { /* none by itself: the decoder looked at all that move */
        for (std::size_t n = 1; n < record.size(); n++) {
            if (way_of(n) != 0.0) {
                rows.push_back(n);
            }
        }
    }
    std::size_t all = 0; /* with those that another channel has shown */
    std::vector<std::uint8_t> counted(record.size(), 0);
    for (const std::size_t n : rows) {
        counted[n] = 1;
        all += events.lost_command[n] != 0;
    }
    return {found_in("robot.lost_commands", all, events.lost_command, counted)};
}

} // namespace berth
