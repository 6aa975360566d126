#include "single_samples.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "../fit/base.h"
#include "../noise/floor.h"
#include "../record/command_steps.h"
#include "../replay/driven_path.h"
#include "lost_commands.h"
#include "spikes.h"

namespace berth
{

namespace
{

/* In the validation record, so that it can show what else is explained. */
void find_in_unseen(block block, const diagnosis_input &input, const rig &given, const rig &known,
                    std::string_view effect, sample_events &unseen)
{
    if (input.validation == nullptr) {
        return;
    }
    block_model plain(block, *input.validation, given, unseen, held_out_parts::none);
    std::vector<double> error;
    plain.error(known, error);
    if (effect == "sensor.spikes") {
        find_spikes(plain, error, unseen);
    } else {
        loss_search search;
        find_lost_commands(plain, known, error, unseen, search);
        block_model with_them(block, *input.validation, given, unseen, held_out_parts::none);
        with_them.error(known, error);
        find_lost_commands(with_them, known, error, unseen, search);
    }
}

/* Of this block, with the base that was tuned with those found so far. */
std::vector<event_finding> find_losses(block block, const diagnosis_input &input, const rig &given, const rig &base,
                                       sample_events &events, loss_search &search)
{
    const sample_events before = events;
    std::vector<double> error;
    block_model plain(block, *input.fit, given, events, held_out_parts::none);
    plain.error(base, error);
    std::vector<event_finding> found = find_lost_commands(plain, base, error, events, search);
    if (block == block::robot && !found.empty() && can_replay(*input.fit, block::force)) {
        block_model force(block::force, *input.fit, given, before, held_out_parts::none);
        if (!force_knows_of(force, base, events)) {
            events = before; /* samples that were not taken, rather than setpoints */
            found.clear();
        }
    }
    return found;
}

/* The same where a replay with them has nothing to add. */
std::vector<event_finding> find_losses_surely(block block, const diagnosis_input &input, const rig &given,
                                              const rig &base, sample_events &events)
{
    loss_search search;
    search.polish = true;
    std::vector<event_finding> found = find_losses(block, input, given, base, events, search);
    if (found.empty()) {
        return found;
    }
    std::vector<double> error;
    block_model with_them(block, *input.fit, given, events, held_out_parts::none);
    with_them.error(base, error);
    const std::vector<event_finding> again = find_lost_commands(with_them, base, error, events, search);
    return again.empty() ? found : again;
}

} // namespace

void find_single_samples(block block, const diagnosis_input &input, const rig &given, events_of_records &events,
                         std::vector<event_finding> &found)
{
    const sample_events before = events.fit;
    bool may_lose = block != block::manipulator && given.robot.clock == robot_clock::locked;
    const spikes_wanted wanted =
        input.without_switching_fault != nullptr ? spikes_wanted::of_one_size : spikes_wanted::all;
    rig base = given;
    std::vector<double> error;
    const double steps_rms = may_lose ? rms_of_command_steps(block, *input.fit, given, events.fit) : 0.0;
    /* Each pass tunes the base with what the one before found, until they find the same. */
    constexpr int passes_max = 12;
    loss_search search{follows_setpoints(given) ? left_by_wrong_base : left_by_wrong_limit};
    for (int pass = 0; pass < passes_max; pass++) {
        block_model model(block, *input.fit, given, events.fit, held_out_parts::none);
        model.error(base, error);
        const noise_model noise = noise_of(model, error, true);
        base =
            fit(model, noise, base, joined(input.upstream, base_parameters(block, given)), input.options.replays_max)
                .rig;
        if (steps_rms > 0.0 &&
            !were_steps_sent(block, *input.fit, base,
                             events.fit)) { /* setpoints that were rounded lead elsewhere, as lost ones do */
            model.error(base, error);
            may_lose =
                may_lose && !is_of_input_steps(rms_of(error, model.uses(), row_use::fit), steps_rms, noise.rms);
        }
        const std::vector<std::uint8_t> lost_before = std::exchange(events.fit, before).lost_command;
        std::vector<event_finding> now;
        if (may_lose) {
            now = find_losses(block, input, given, base, events.fit, search);
            search.decode_alone = search.was_decoded;
        }
        const bool is_last = pass > 0 && (events.fit.lost_command == lost_before || pass + 1 == passes_max);
        if (is_last && !now.empty()) {
            events.fit = before;
            now = find_losses_surely(block, input, given, base, events.fit);
        }
        if (block == block::force && now.empty() && !input.options.robot_in_force) {
            block_model plain(block, *input.fit, given, events.fit, held_out_parts::none);
            plain.error(base, error);
            now = find_spikes(plain, error, events.fit, wanted);
        }
        if (now.empty()) {
            if (count_of(events.fit.lost_command) > 0) { /* in the channel before: this one may show more of them */
                find_in_unseen(block, input, given, base, "robot.lost_commands", events.unseen);
            }
            return;
        }
        if (is_last) {
            find_in_unseen(block, input, given, base, now[0].effect->name, events.unseen);
            found.insert(found.end(), now.begin(), now.end());
            return;
        }
    }
}

bool verify_spikes(block block, const diagnosis_input &input, const block_diagnosis &result,
                   events_of_records &events, std::vector<event_finding> &found)
{
    const auto spikes = std::find_if(found.begin(), found.end(),
                                     [](const event_finding &one) { return one.effect->name == "sensor.spikes"; });
    if (block != block::force || spikes == found.end()) {
        return false;
    }
    const std::vector<std::uint8_t> before = std::exchange(events.fit.spike, {});
    const std::vector<std::uint8_t> unseen_before = std::exchange(events.unseen.spike, {});
    block_model model(block, *input.fit, result.extended, events.fit, held_out_parts::none);
    std::vector<double> error;
    model.error(result.extended, error);
    const std::vector<event_finding> again = find_spikes(model, error, events.fit);
    if (again.empty() || 2 * again[0].count < spikes->count) {
        found.erase(spikes);
        events.fit.spike.clear();
        return false;
    }
    *spikes = again[0];
    find_in_unseen(block, input, result.extended, result.extended, "sensor.spikes", events.unseen);
    return events.fit.spike != before || events.unseen.spike != unseen_before;
}

double share_explained_by(const event_finding &found, block block, const diagnosis_input &input, const rig &given,
                          const rig &extended, const sample_events &events, double floor_rms)
{
    using rows = std::vector<std::uint8_t> sample_events::*;
    constexpr std::pair<std::string_view, rows> rows_of_effects[] = {
        {"robot.lost_commands", &sample_events::lost_command},
        {"loop.lost_samples", &sample_events::robot_repeats},
        {"loop.lost_samples", &sample_events::force_repeats},
        {"sensor.dropouts", &sample_events::force_repeats},
        {"sensor.spikes", &sample_events::spike}};
    sample_events without = events;
    for (const auto &[effect, of_effect] : rows_of_effects) {
        if (found.effect->name == effect) {
            (without.*of_effect).clear();
        }
    }
    double count = 0.0;
    const auto square_with = [&](const rig &rig, const sample_events &known) {
        block_model model(block, *input.fit, rig, known, held_out_parts::none);
        std::vector<double> error;
        model.error(rig, error);
        count = static_cast<double>(std::count(model.uses().begin(), model.uses().end(), row_use::fit));
        return std::pow(rms_of(error, model.uses(), row_use::fit), 2) * count;
    };
    const double left = square_with(extended, events);
    const double before = square_with(extended, without);
    const double as_given = std::max(before, square_with(given, {}));
    const double explainable = as_given - floor_rms * floor_rms * count;
    return before > left && explainable > 0.0 ? std::min(1.0, (before - left) / explainable)
                                              : std::numeric_limits<double>::quiet_NaN();
}

} // namespace berth
