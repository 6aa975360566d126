#include "lost_commands.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "../replay/driven_path.h"
#include "loss_finder.h"
#include "loss_polisher.h"

namespace berth
{

namespace
{

/* Of the setpoints that would be seen: where more are missing, what stands still has another reason. */
constexpr double share_lost_max = 0.25;

bool are_too_many(const event_finding &found)
{
    return found.values[0] > share_lost_max;
}

/* Chance does not care how far a setpoint leads: where nearly only the smallest steps are missing, it is a
 * threshold. */
bool are_the_smallest(const std::vector<double> &steps_m, const std::vector<std::uint8_t> &lost)
{
    std::vector<double> missing;
    std::vector<double> done;
    for (std::size_t n = 1; n < steps_m.size(); n++) {
        (lost[n] != 0 ? missing : done).push_back(steps_m[n]);
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

/* From where the last one that was taken led. */
std::vector<double> steps_of(const std::vector<double> &sent, const std::vector<std::uint8_t> &lost)
{
    const std::vector<double> taken = taken_of(sent, lost);
    std::vector<double> steps_m(sent.size(), 0.0);
    for (std::size_t n = 1; n < sent.size(); n++) {
        steps_m[n] = std::abs(sent[n] - taken[n - 1]);
    }
    return steps_m;
}

/* Those of the setpoints whose loss this block would show, or one before it would; where none of these was lost, of
 * all that `lead` anywhere. */
event_finding finding_among(std::vector<std::uint8_t> shown, const std::vector<std::uint8_t> &lead,
                            sample_events &events)
{
    const auto lost_of = [&](const std::vector<std::uint8_t> &rows) {
        std::size_t count = 0;
        for (std::size_t n = 0; n < rows.size(); n++) {
            count += rows[n] != 0 && events.lost_command[n] != 0;
        }
        return count;
    };
    events.loss_shows.resize(shown.size(), 0);
    std::transform(shown.begin(), shown.end(), events.loss_shows.begin(), events.loss_shows.begin(),
                   [](std::uint8_t here, std::uint8_t before) { return here | before; });
    const std::vector<std::uint8_t> &counted = lost_of(events.loss_shows) > 0 ? events.loss_shows : lead;
    return found_in("robot.lost_commands", lost_of(counted), events.lost_command, counted);
}

std::vector<std::uint8_t> rows_that_lead(const std::vector<double> &command_m)
{
    std::vector<std::uint8_t> made(command_m.size(), 0);
    for (std::size_t n = 1; n < command_m.size(); n++) {
        made[n] = command_m[n] != command_m[n - 1];
    }
    return made;
}

/* The same where what a setpoint does depends on those before it. */
event_finding finding_behind_what_switches(const rig &rig, const record &record, double clear_m,
                                           sample_events &events)
{
    const std::vector<double> at_stake_m = way_at_stake_m(rig, record, events.lost_command);
    std::vector<std::uint8_t> shown(record.size(), 0);
    std::vector<std::uint8_t> lead(record.size(), 0);
    for (std::size_t n = 1; n < record.size(); n++) {
        shown[n] = at_stake_m[n] > clear_m;
        lead[n] = at_stake_m[n] > 0.0;
    }
    return finding_among(std::move(shown), lead, events);
}

/* Of those that would do anything: a dead band that is wider than it is taken for loses the smallest. */
bool are_the_smallest_at_stake(const rig &rig, const record &record, const std::vector<std::uint8_t> &lost)
{
    const std::vector<double> all_m = way_at_stake_m(rig, record, lost);
    std::vector<double> at_stake_m = {0.0};
    std::vector<std::uint8_t> lost_at_stake = {0};
    for (std::size_t n = 1; n < all_m.size(); n++) {
        if (all_m[n] > 0.0) {
            at_stake_m.push_back(all_m[n]);
            lost_at_stake.push_back(lost[n]);
        }
    }
    return are_the_smallest(at_stake_m, lost_at_stake);
}

/* Where what a setpoint does depends on those before it, all are decided in turn. */
std::vector<event_finding> decode_behind_what_switches(block_model &model, const rig &rig, const loss_trace &loss,
                                                       sample_events &events, loss_search &search)
{
    const record &record = model.data();
    const sample_events none;
    block_model plain(model.which(), record, rig, none, held_out_parts::none);
    plain.use(model.uses());
    std::vector<double> error;
    plain.error(rig, error);
    std::vector<std::uint8_t> known = events.lost_command;
    known.resize(error.size(), 0);
    const std::vector<std::uint8_t> nothing(error.size(), 0);
    loss_finder finder(plain, rig, loss, error, nothing, 0);
    finder.decode(search.left_max);
    search.was_decoded = true;
    if (!finder.is_decoded) {
        return {};
    }
    if (count_of(known) > 0) {
        model.error(rig, error);
        if (finder.cost_of(error, known) <= finder.cost()) {
            search.was_decoded = false;
            return {};
        }
    }
    const std::size_t count = count_of(finder.lost);
    if (count < events_min || finder.lost == known || 4 * count > error.size() ||
        finder.share_left() > search.left_max) {
        return {};
    }
    const sample_events before = events;
    events.lost_command = std::move(finder.lost);
    if (search.polish) {
        block_model with_them(model.which(), record, rig, events, held_out_parts::none);
        with_them.use(model.uses());
        polish_losses(with_them, rig, loss, finder.least(events.lost_command), events);
    }
    const event_finding found = finding_behind_what_switches(
        rig, record, loss_clear_sd * finder.sigma_left() / std::sqrt(loss.square), events);
    if (are_too_many(found) || are_the_smallest_at_stake(rig, record, events.lost_command)) {
        events = before;
        return {};
    }
    return {found};
}

/* Losses that stand out of the error one by one. */
class clear_losses
{
  public:
    clear_losses(const block_model &model, const loss_trace &loss, const std::vector<double> &error)
        : lost(error.size(), 0), command_m_(model.data().command_position_m), loss_(loss), rest_(error)
    {
        const std::size_t length = loss.values.size();
        const double sigma = sigma_of(error, model.uses());
        for (std::size_t n = 1; n + loss.first + length < model.data().size(); n++) {
            const std::size_t from = n + loss.first;
            if (std::abs(way_m(n)) * std::sqrt(loss.square) > loss_clear_sd * sigma &&
                model.uses()[from] != row_use::none && model.uses()[from + length - 1] != row_use::none) {
                rows.push_back(n);
                shares_.push_back(share_at(n));
            }
        }
        usual_ = median_of(shares_);
        take_out();
    }

    bool are_clear() const
    {
        const auto is_opposite = [&](double share) { return share - usual_ < -like; }; /* there is no such thing */
        const auto opposites = static_cast<std::size_t>(std::count_if(shares_.begin(), shares_.end(), is_opposite));
        return hits_ >= events_min && opposites * 4 <= hits_ && are_few();
    }

    std::vector<std::uint8_t> shown() const
    {
        std::vector<std::uint8_t> made(lost.size(), 0);
        for (const std::size_t n : rows) {
            made[n] = 1;
        }
        return made;
    }

    std::vector<std::size_t> rows;  /* whose loss would stand out */
    std::vector<std::uint8_t> lost; /* of all rows */

  private:
    static constexpr double like = 0.75; /* share of a loss that the error must show */

    double way_m(std::size_t n) const { return command_m_[n] - command_m_[n - 1]; }
    bool are_few() const { return hits_ * 4 <= rows.size(); }

    /* Share of the trace that the error shows from a setpoint on. */
    double share_at(std::size_t n) const
    {
        double sum = 0.0;
        for (std::size_t k = 0; k < loss_.values.size(); k++) {
            sum += loss_.values[k] * rest_[n + loss_.first + k];
        }
        return sum / (way_m(n) * loss_.square);
    }

    /* By how much the sum of squares falls if this setpoint was lost; only where it looks like one. */
    double promise_of(std::size_t i) const
    {
        const double share = shares_[i] - usual_;
        const double way = way_m(rows[i]);
        return share > like ? (2.0 * share - 1.0) * way * way : 0.0;
    }

    /* The clearest one first; it is taken out before the next one is looked for. */
    void take_out()
    {
        const std::size_t length = loss_.values.size();
        std::vector<double> promises(rows.size());
        for (std::size_t i = 0; i < rows.size(); i++) {
            promises[i] = promise_of(i);
        }
        while (are_few()) {
            const auto best = std::max_element(promises.begin(), promises.end());
            if (best == promises.end() || *best <= 0.0) {
                break;
            }
            const std::size_t n = rows[static_cast<std::size_t>(best - promises.begin())];
            for (std::size_t k = 0; k < length; k++) {
                rest_[n + loss_.first + k] -= way_m(n) * loss_.values[k];
            }
            lost[n] = 1;
            hits_++;
            const auto begin =
                std::lower_bound(rows.begin(), rows.end(), n > length ? n - length : 0) - rows.begin();
            for (auto i = static_cast<std::size_t>(begin); i < rows.size() && rows[i] < n + length; i++) {
                shares_[i] = share_at(rows[i]);
                promises[i] = lost[rows[i]] != 0 ? 0.0 : promise_of(i);
            }
        }
    }

    const std::vector<double> &command_m_;
    const loss_trace &loss_;
    std::vector<double> rest_;
    std::vector<double> shares_; /* at rows */
    double usual_ = 0.0;         /* a wrong dead time looks like a little of a loss at every setpoint */
    std::size_t hits_ = 0;
};

} // namespace

bool force_knows_of(block_model &force, const rig &rig, const sample_events &events)
{
    const loss_trace loss = trace_of_loss(force, rig);
    const record &record = force.data();
    std::vector<double> error;
    force.error(rig, error);
    block_model with_them(block::force, record, rig, events, held_out_parts::none);
    std::vector<double> left;
    with_them.error(rig, left);
    /* A grip that has given way feels nothing, and otherwise than this model after it: it is not asked. */
    constexpr double held_share = 0.5;
    constexpr double felt_sd = 2.0; /* of the noise, over all of its trace: before a contact it is felt less */
    /* Of what is felt at twice the noise a share is uncertain by 0.5, the median of n by 1.25 / sqrt(n) times that:
     * four times this is no chance, though losses that are not found beside them hide a part of each. */
    constexpr double all_by_chance = 2.5;
    const double least_N = 0.1 * rms_of(record.force_N, force.uses(), row_use::fit);
    const double felt_square = std::pow(felt_sd * sigma_of(error, force.uses()), 2);
    const std::vector<double> lacked_m = way_lacked_m(rig, record, events.lost_command);
    std::vector<double> shares;
    std::size_t asked = 0;
    std::size_t held = 0;
    for (std::size_t n = 1; n + loss.first + loss.values.size() < record.size() && !loss.values.empty(); n++) {
        if (events.lost_command[n] == 0 || lacked_m[n] == 0.0) {
            continue;
        }
        double sum = 0.0;
        double square = 0.0;
        double largest_N = 0.0;
        for (std::size_t at = n + loss.first; at < n + loss.first + loss.values.size(); at++) {
            const double done = error[at] - left[at];
            sum += done * error[at];
            square += done * done;
            largest_N = std::max(largest_N, std::abs(record.force_N[at]));
        }
        asked++;
        if (largest_N > least_N) {
            held++;
            if (square > felt_square) {
                shares.push_back(sum / square);
            }
        }
    }
    const double by_chance = all_by_chance / std::sqrt(static_cast<double>(shares.size()));
    return shares.size() < events_min || median_of(shares) > std::min(0.5, by_chance) ||
           static_cast<double>(held) < held_share * static_cast<double>(asked);
}

std::vector<event_finding> find_lost_commands(block_model &model, const rig &rig, const std::vector<double> &error,
                                              sample_events &events, loss_search &search)
{
    const loss_trace loss = trace_of_loss(model, rig);
    if (loss.values.empty()) {
        return {};
    }
    if (!follows_setpoints(rig)) {
        return decode_behind_what_switches(model, rig, loss, events, search);
    }
    clear_losses clear(model, loss, error);
    const bool are_clear = clear.are_clear();
    std::vector<std::uint8_t> known = events.lost_command;
    known.resize(error.size(), 0);
    loss_finder finder(model, rig, loss, error, known, clear.rows.size());
    const bool is_new = count_of(known) == 0;
    const double left_max = are_clear || !is_new ? unlimited : search.left_max;
    if (search.decode_alone) {
        finder.decode(left_max);
    } else {
        std::vector<std::uint8_t> lost = known;
        for (std::size_t n = 0; n < lost.size() && are_clear; n++) {
            lost[n] = known[n] != 0 || clear.lost[n] != 0;
        }
        finder.settle(std::move(lost), left_max);
    }
    search.was_decoded = finder.is_decoded;
    const bool explain_most = finder.share_left() < search.left_max && count_of(finder.lost) >= events_min;
    if (finder.lost == known || !(are_clear || !is_new || explain_most) ||
        (is_new && (4 * count_of(finder.lost) > error.size() ||
                    are_the_smallest(steps_of(model.data().command_position_m, finder.lost), finder.lost)))) {
        return {};
    }
    const sample_events before = events;
    events.lost_command = std::move(finder.lost);
    const event_finding found =
        finding_among(clear.shown(), rows_that_lead(model.data().command_position_m), events);
    if (are_too_many(found)) {
        events = before;
        return {};
    }
    return {found};
}

} // namespace berth
