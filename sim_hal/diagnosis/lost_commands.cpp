#include "lost_commands.h"

#include <algorithm>
#include <cmath>

namespace berth
{

namespace
{

/* What the loss of one setpoint does to the output, for 1 m of way that the robot lacks: from the tick after the
 * setpoint on. */
struct trace {
    std::size_t first; /* ticks after the setpoint */
    std::vector<double> values;
    double square = 0.0;
};

trace trace_of_loss(block_model &model, const rig &rig)
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
    trace made{0, {}};
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

/* Standard deviation of most of it. */
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

/* Setpoints that the robot stands on in each row: of lost ones those before. */
std::vector<double> taken_of(const std::vector<double> &sent, const std::vector<std::uint8_t> &lost)
{
    std::vector<double> taken = sent;
    for (std::size_t n = 1; n < taken.size(); n++) {
        taken[n] = lost[n] != 0 ? taken[n - 1] : sent[n];
    }
    return taken;
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

/* Losses next to each other are not the sum of losses: of the second one the robot lacks the first one's way, too.
 * So each setpoint is taken for lost, or for not lost after all, where the error is smaller for it, alone or with
 * one of its neighbours: a loss found one tick off is two mistakes. */
class loss_settler
{
  public:
    /* `error`: of a replay with the losses that were `known`. */
    loss_settler(const block_model &model, const trace &loss, const std::vector<double> &error,
                 const std::vector<std::uint8_t> &known, std::vector<std::uint8_t> first_guess)
        : lost(std::move(first_guess)), model_(model), loss_(loss), sent_(model.data().command_position_m),
          rest_(error), end_(sent_.size() - std::min(sent_.size(), loss.first + loss.values.size()))
    {
        taken_ = taken_of(sent_, known);
        const std::vector<double> taken = taken_of(sent_, lost);
        for (std::size_t n = 0; n < end_; n++) {
            put(n, taken[n]);
        }
    }

    /* `least`: squares of sigma that a loss has to explain. */
    void settle(double least)
    {
        constexpr int rounds = 8;
        constexpr std::size_t apart_max = 3;
        bool any = true;
        for (int round = 0; round < rounds && any; round++) {
            const double sigma = sigma_of(rest_, model_.uses());
            any = false;
            for (std::size_t n = 1; n + apart_max < end_; n++) {
                for (std::size_t apart = 0; apart < apart_max; apart++) {
                    any = try_flip(n, n + apart, least * sigma * sigma) || any;
                }
            }
        }
    }

    /* Sum of squares that is left. */
    double square() const { return square(0, rest_.size()); }

    std::vector<std::uint8_t> lost;

  private:
    /* Where one in four is lost, the most that is looked at, 400 a second, once in a year more are lost in a
     * row: what stands still for longer has another reason. */
    static constexpr std::size_t run_max = 16;

    double square(std::size_t begin, std::size_t end) const
    {
        double sum = 0.0;
        for (std::size_t row = begin; row < end; row++) {
            sum += model_.uses()[row] == row_use::none ? 0.0 : rest_[row] * rest_[row];
        }
        return sum;
    }

    bool try_flip(std::size_t first, std::size_t second, double least)
    {
        const int more = (lost[first] == 0 ? 1 : -1) + (second == first ? 0 : lost[second] == 0 ? 1 : -1);
        const auto flip = [&] {
            lost[first] = lost[first] == 0;
            lost[second] = second == first ? lost[second] : lost[second] == 0;
        };
        flip();
        std::size_t last = second + 1;
        while (last < end_ && lost[last] != 0) {
            last++;
        }
        if (more > 0 && longest_run(first, last) > run_max) {
            flip();
            return false;
        }
        const std::vector<double> before(taken_.begin() + static_cast<std::ptrdiff_t>(first),
                                         taken_.begin() + static_cast<std::ptrdiff_t>(last));
        const std::size_t to = last - 1 + loss_.first + loss_.values.size();
        const double square_before = square(first + loss_.first, to);
        double standing = taken_[first - 1];
        for (std::size_t n = first; n < last; n++) {
            standing = lost[n] != 0 ? standing : sent_[n];
            put(n, standing);
        }
        if (square_before - square(first + loss_.first, to) > least * std::max(0, more)) {
            return true;
        }
        flip();
        for (std::size_t n = first; n < last; n++) {
            put(n, before[n - first]);
        }
        return false;
    }

    /* Of losses one after the other, of which one is at `first` or later, up to `last`. */
    std::size_t longest_run(std::size_t first, std::size_t last) const
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

    /* The robot stands on this setpoint in tick n; the error is then another one. */
    void put(std::size_t n, double taken)
    {
        const double way = taken_[n] - taken;
        for (std::size_t k = 0; k < loss_.values.size() && way != 0.0; k++) {
            rest_[n + loss_.first + k] -= way * loss_.values[k];
        }
        taken_[n] = taken;
    }

    const block_model &model_;
    const trace &loss_;
    const std::vector<double> &sent_;
    std::vector<double> rest_;
    std::vector<double> taken_;
    std::size_t end_;
};

} // namespace

bool force_knows_of(block_model &force, const rig &rig, const sample_events &events)
{
    const trace loss = trace_of_loss(force, rig);
    std::vector<double> error;
    force.error(rig, error);
    const record &record = force.data();
    std::vector<double> shares;
    for (std::size_t n = 1; n + loss.first + loss.values.size() < record.size() && !loss.values.empty(); n++) {
        if (events.lost_command[n] != 0) {
            const double way = record.command_position_m[n] - record.command_position_m[n - 1];
            double sum = 0.0;
            for (std::size_t k = 0; k < loss.values.size(); k++) {
                sum += loss.values[k] * error[n + loss.first + k];
            }
            shares.push_back(sum / (way * loss.square));
        }
    }
    return median_of(shares) > 0.5;
}

std::vector<event_finding> find_lost_commands(block_model &model, const rig &rig, const std::vector<double> &error,
                                              sample_events &events)
{
    constexpr double like = 0.75;      /* share of a loss that the error must show */
    constexpr double nearly_all = 0.1; /* of the squares may be left where no loss is clear by itself */
    const record &record = model.data();
    const trace loss = trace_of_loss(model, rig);
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
    loss_settler settler(model, loss, error, known, std::move(lost));
    const double square_before = settler.square();
    /* Where one in eight is lost, less has to speak for it than where one in a thousand is. */
    constexpr double sure = 6.0; /* logarithm of the odds */
    const double odds = static_cast<double>(rows.size()) / static_cast<double>(count_of(settler.lost) + 1);
    settler.settle(2.0 * (std::log(odds) + sure));
    const bool explain_all = settler.square() < nearly_all * square_before;
    const std::size_t count = count_of(settler.lost);
    const bool are_some = are_clear || count_of(known) > 0 || (explain_all && count >= events_min);
    const bool is_new = count_of(known) == 0;
    if (!are_some || settler.lost == known || (is_new && 4 * count > error.size()) ||
        (is_new && are_the_smallest(record.command_position_m, settler.lost))) {
        return {};
    }
    events.lost_command = std::move(settler.lost);
    std::size_t all = 0; /* with those that another channel has shown */
    for (const std::size_t n : rows) {
        all += events.lost_command[n] != 0;
    }
    return {found_in("robot.lost_commands", all, rows.size())};
}

} // namespace berth
