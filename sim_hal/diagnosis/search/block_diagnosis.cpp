#include "block_diagnosis.h"

#include <algorithm>
#include <cmath>

#include "../replay/driven_path.h"
#include "../samples/single_samples.h"
#include "../samples/switch_beside_losses.h"
#include "acceptance.h"
#include "block_search.h"

namespace berth
{

namespace
{

/* The error is hardly more than that of rounding, which follows the motion and looks like many things: by its size,
 * or as every row lies within half a step, however long the motion rests where that is far off. */
bool is_rounding_alone(const event_finding &steps, const block_diagnosis &result)
{
    constexpr double nearly = 0.9;
    constexpr double half = 0.53; /* of a step; a little more for the noise */
    constexpr double all = 0.99;  /* of the rows */
    const double step = steps.values[0];
    std::size_t rows = 0;
    std::size_t within = 0;
    for (std::size_t n = 0; n < result.error_after.size(); n++) {
        const bool is_compared = result.uses[n] != row_use::none;
        rows += is_compared;
        within += is_compared && std::abs(result.error_after[n]) <= half * step;
    }
    return step / std::sqrt(12.0) > nearly * result.fit_rms.after ||
           static_cast<double>(within) >= all * static_cast<double>(rows);
}

/* Setpoints that are lost show only once the robot is right but for them: after a cause that its tolerances do not
 * hold, such as another dead time, they are looked for again, also where they would pass for noise. */
bool find_losses_behind(block block, const diagnosis_input &input, const rig &given, const block_diagnosis &result,
                        events_of_records &events, std::vector<event_finding> &found_events)
{
    /* Behind what switches, losses that pass for noise would take as long as the whole search. */
    const bool is_open = result.verdict == verdict::partly_explained ||
                         (result.verdict == verdict::named && follows_setpoints(result.extended));
    if (block != block::robot || result.causes.empty() || !is_open) {
        return false;
    }
    const std::vector<std::uint8_t> known = events.fit.lost_command;
    const std::optional<rig> with_switch = switch_beside_losses(input, given, result);
    std::vector<event_finding> found;
    find_single_samples(block, input, with_switch.value_or(result.extended), events, found);
    for (const event_finding &one : found) {
        found_events.erase(
            std::remove_if(found_events.begin(), found_events.end(),
                           [&](const event_finding &earlier) { return earlier.effect == one.effect; }),
            found_events.end());
        found_events.push_back(one);
    }
    return !found.empty() && events.fit.lost_command != known;
}

/* Setpoints that were lost are decoded in what the base leaves: a cause beside it, such as a bias, has led a few of
 * them astray. `before`, `told`: the events, and the number of findings, of the blocks before. */
bool find_losses_beside(const diagnosis_input &input, const block_diagnosis &result, const events_of_records &before,
                        std::ptrdiff_t told, events_of_records &events, std::vector<event_finding> &found_events)
{
    const auto is_loss = [](const event_finding &one) { return one.effect->name == "robot.lost_commands"; };
    const bool has_losses = std::any_of(found_events.begin() + told, found_events.end(), is_loss);
    if (result.block != block::force || result.causes.empty() || !has_losses ||
        result.verdict != verdict::partly_explained) {
        return false;
    }
    events_of_records again = before;
    std::vector<event_finding> found;
    find_single_samples(block::force, input, result.extended, again, found);
    if (std::none_of(found.begin(), found.end(), is_loss) || again.fit.lost_command == events.fit.lost_command) {
        return false;
    }
    events = std::move(again);
    found_events.erase(found_events.begin() + told, found_events.end());
    found_events.insert(found_events.end(), found.begin(), found.end());
    return true;
}

/* What was found first may stand in for two others of which neither alone explains as much, as a play does for a
 * dead band and a longer dead time: where something is left, it is searched for once more without each of the
 * causes, and what then explains all is taken. */
void search_without_stand_in(block block, const diagnosis_input &input, const rig &given,
                             const events_of_records &events, block_diagnosis &result)
{
    constexpr double above_floor = 1.1;
    constexpr std::size_t tries_max = 2;
    if (!input.may_search_again || result.verdict != verdict::partly_explained ||
        result.fit_rms.after < above_floor * result.fit_rms.floor) {
        return;
    }
    const auto rows = static_cast<double>(std::count(result.uses.begin(), result.uses.end(), row_use::fit));
    for (std::size_t i = 0; i < std::min(tries_max, result.causes.size()); i++) {
        diagnosis_input without = input;
        without.options.without.emplace_back(result.causes[i].effect->name);
        block_diagnosis other;
        other.block = block;
        block_search(block, without, given, events).run(other);
        const double better = 2.0 * rows * std::log(result.fit_rms.after / other.fit_rms.after);
        if (other.verdict == verdict::named && better > bic_beyond_doubt) {
            result = std::move(other);
            return;
        }
    }
}

} // namespace

block_diagnosis diagnose_block(block block, const diagnosis_input &input, const rig &given,
                               events_of_records &events, std::vector<event_finding> found_events)
{
    block_diagnosis result;
    result.block = block;
    const auto told = static_cast<std::ptrdiff_t>(found_events.size());
    const events_of_records events_before = events;
    find_single_samples(block, input, given, events, found_events);
    /* A fault that switches a little otherwise than ours leaves an error that a row of losses would make. */
    if (block == block::force && input.without_switching_fault != nullptr &&
        std::any_of(found_events.begin() + told, found_events.end(),
                    [](const event_finding &one) { return one.in_bursts; })) {
        found_events.erase(found_events.begin() + told, found_events.end());
        events = events_before;
    }
    diagnosis_input known = input;
    known.has_events = !found_events.empty();
    block_search(block, known, given, events).run(result);
    search_without_stand_in(block, known, given, events, result);
    if (verify_spikes(block, input, result, events, found_events) ||
        find_losses_behind(block, input, given, result, events, found_events) ||
        find_losses_beside(input, result, events_before, told, events, found_events)) {
        result = {};
        result.block = block;
        known.has_events = true;
        block_search(block, known, given, events).run(result);
    }
    /* What follows the moments of a grip is no loss, and what was taken for lost hides the moments. */
    const bool all_follows = std::any_of(result.causes.begin(), result.causes.end(),
                                         [](const cause &one) { return one.effect->decides_what_follows; });
    if (all_follows && static_cast<std::ptrdiff_t>(found_events.size()) > told) {
        found_events.erase(found_events.begin() + told, found_events.end());
        events = events_before;
        known.has_events = !found_events.empty();
        result = {};
        result.block = block;
        block_search(block, known, given, events).run(result);
    }
    if (const auto printable = result.printable) {
        result = *printable;
    }
    if (block == block::force) {
        const auto steps = find_quantisation(*input.fit, given, result.fit_rms.after);
        if (!steps.empty() && result.causes.empty() && is_rounding_alone(steps[0], result)) {
            result.verdict = verdict::nothing_detectable;
            result.doubts.clear();
        }
        found_events.insert(found_events.end(), steps.begin(), steps.end());
    }
    const auto &without = input.options.without;
    for (const event_finding &found : found_events) {
        const bool is_removed = std::find(without.begin(), without.end(), found.effect->name) != without.end();
        if (is_removed) {
            result.verdict = result.causes.empty() ? verdict::unknown : verdict::partly_explained;
            continue;
        }
        cause made;
        made.effect = found.effect;
        made.share_explained =
            share_explained_by(found, block, input, given, result.extended, events.fit, result.fit_rms.floor);
        for (std::size_t i = 0; i < found.values.size(); i++) {
            made.parameters.push_back(
                {std::string(found.effect->parameters[i].key), found.values[i], found.ci95[i]});
            set_number(result.extended, found.effect->parameters[i].key, found.values[i]);
        }
        result.causes.push_back(made);
        if (result.verdict == verdict::nothing_detectable) {
            result.verdict = verdict::named;
        }
        if (found.in_bursts) {
            result.verdict = verdict::partly_explained;
            result.doubts.emplace_back("what is lost comes in bursts, and the effect loses one by one");
        }
    }
    if (result.verdict == verdict::unknown && !result.causes.empty()) {
        result.verdict = verdict::partly_explained;
    }
    return result;
}

} // namespace berth
