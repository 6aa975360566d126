#include "sample_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "../decide/stretches.h"

namespace berth
{

namespace
{

using rows_of_events = std::vector<std::uint8_t> sample_events::*;

struct kind_of_events {
    std::string_view effect;
    rows_of_events rows;
    bool is_chosen_by_error; /* and not seen in the data themselves */
};

constexpr kind_of_events kinds[] = {{"robot.lost_commands", &sample_events::lost_command, true},
                                    {"loop.lost_samples", &sample_events::robot_repeats, false},
                                    {"loop.lost_samples", &sample_events::force_repeats, false},
                                    {"sensor.dropouts", &sample_events::force_repeats, false},
                                    {"sensor.spikes", &sample_events::spike, true}};

/* The same events but for those of one finding, and where those are. */
struct divided_events {
    sample_events others;
    std::vector<std::uint8_t> rows; /* empty: none */
    bool are_chosen_by_error = false;
};

divided_events divided(const sample_events &events, std::string_view effect)
{
    divided_events made{events, {}, false};
    for (const kind_of_events &kind : kinds) {
        std::vector<std::uint8_t> &of_kind = made.others.*kind.rows;
        if (kind.effect != effect || of_kind.empty()) {
            continue;
        }
        made.rows.resize(std::max(made.rows.size(), of_kind.size()), 0);
        for (std::size_t n = 0; n < of_kind.size(); n++) {
            made.rows[n] |= of_kind[n];
        }
        made.are_chosen_by_error = kind.is_chosen_by_error;
        of_kind.clear();
    }
    return made;
}

/* Squared errors by row of a rig, with the events of a finding and without. */
struct two_replays {
    std::vector<double> with;
    std::vector<double> without;
    std::vector<std::uint8_t> rows; /* of the events */
    std::vector<bool> counts;       /* rows that are compared without the events */
};

two_replays replays_of(block block, const record &data, const rig &given, const rig &with_rig,
                       const sample_events &events, std::string_view effect, double noise_rms)
{
    const divided_events of = divided(events, effect);
    two_replays made;
    block_model with(block, data, given, events, held_out_parts::none);
    block_model without(block, data, given, of.others, held_out_parts::none);
    with.error(with_rig, made.with);
    without.error(with_rig, made.without);
    made.rows = of.rows;
    made.rows.resize(data.size(), 0);
    const auto count = static_cast<double>(std::count(made.rows.begin(), made.rows.end(), 1));
    const double which =
        of.are_chosen_by_error && count > 0.0 ? 2.0 * std::log(static_cast<double>(data.size()) / count) : 0.0;
    const double price = noise_rms * noise_rms * (1.0 + which);
    made.counts.resize(data.size());
    for (std::size_t n = 0; n < data.size(); n++) {
        made.counts[n] = without.uses()[n] == row_use::fit;
        const bool is_compared = with.uses()[n] == row_use::fit;
        made.with[n] = (is_compared ? made.with[n] * made.with[n] : 0.0) + (made.rows[n] != 0 ? price : 0.0);
        made.without[n] *= made.without[n];
    }
    return made;
}

void add_stretches_with_events(cause_evidence &made, const two_replays &replays, const std::vector<bool> &counts,
                               std::size_t stretches)
{
    const std::vector<double> with = sums_by_stretch(replays.with, counts, stretches);
    const std::vector<double> without = sums_by_stretch(replays.without, counts, stretches);
    const std::vector<double> events =
        sums_by_stretch({replays.rows.begin(), replays.rows.end()}, counts, stretches);
    for (std::size_t i = 0; i < stretches; i++) {
        if (events[i] > 0.0) {
            made.unseen_with.push_back(with[i]);
            made.unseen_without.push_back(without[i]);
        }
    }
}

double sum_over(const std::vector<double> &values, const std::vector<bool> &counts)
{
    return sums_by_stretch(values, counts, 1)[0];
}

std::vector<bool> both(const std::vector<bool> &counts, const std::vector<row_use> &uses, row_use use)
{
    std::vector<bool> made = counts;
    for (std::size_t n = 0; n < made.size(); n++) {
        made[n] = made[n] && uses[n] == use;
    }
    return made;
}

/* Rows that no fit has seen: the rows of events are in no fit, and count here. */
std::vector<row_use> uses_with_events(block block, const diagnosis_input &input, const rig &given,
                                      held_out_parts parts)
{
    const sample_events none;
    return block_model(block, *input.fit, given, none, parts).uses();
}

/* Steps say nothing of the error of a replay that is not rounded. */
cause_evidence evidence_of_steps(const event_finding &found, const block_diagnosis &result, const record &unseen)
{
    const double step = found.values[0];
    const double rounding = step / std::sqrt(12.0);
    cause_evidence made{std::min(1.0, std::pow(rounding / result.fit_rms.after, 2)), found.ci95[0] >= step, {}, {}};
    std::vector<double> off(unseen.size());
    for (std::size_t n = 0; n < unseen.size(); n++) {
        off[n] = std::pow(unseen.force_N[n] - step * std::round(unseen.force_N[n] / step), 2);
    }
    std::vector<bool> counts(unseen.size());
    for (std::size_t n = 0; n < unseen.size(); n++) {
        counts[n] = !unseen.is_filled(n);
    }
    made.unseen_with = sums_by_stretch(off, counts, unseen_stretches);
    made.unseen_without =
        sums_by_stretch(std::vector<double>(unseen.size(), rounding * rounding), counts, unseen_stretches);
    return made;
}

} // namespace

cause_evidence evidence_of_samples(const event_finding &found, const block_diagnosis &result,
                                   const diagnosis_input &input, const rig &given, const events_of_records &events)
{
    const std::string_view effect = found.effect->name;
    const record *const unseen = input.validation != nullptr ? input.validation : nullptr;
    if (effect == "sensor.quantisation") {
        return evidence_of_steps(found, result, unseen != nullptr ? *unseen : *input.fit);
    }
    const double noise_rms = result.fit_rms.floor;
    const auto replayed = [&](const record &data, const sample_events &of, const rig &rig) {
        return replays_of(result.block, data, given, rig, of, effect, noise_rms);
    };
    const two_replays here = replayed(*input.fit, events.fit, result.extended);
    const double left = sum_over(here.with, here.counts);
    const double before = sum_over(here.without, here.counts);
    std::vector<double> error;
    const sample_events none;
    block_model as_given(result.block, *input.fit, given, none, held_out_parts::none);
    as_given.error(given, error);
    const auto rows = static_cast<double>(std::count(here.counts.begin(), here.counts.end(), true));
    const double explainable = std::max(before, std::pow(rms_of(error, as_given.uses(), row_use::fit), 2) * rows) -
                               noise_rms * noise_rms * rows;
    cause_evidence made{before > left && explainable > 0.0 ? std::min(1.0, (before - left) / explainable)
                                                           : std::numeric_limits<double>::quiet_NaN(),
                        found.values[0] <= found.ci95[0],
                        {},
                        {}};
    if (unseen != nullptr) {
        const two_replays there = replayed(*unseen, events.unseen, result.extended);
        add_stretches_with_events(made, there, there.counts, unseen_stretches);
        return made;
    }
    const auto held_out = uses_with_events(result.block, input, given, held_out_parts::two_tenths);
    add_stretches_with_events(made, here, both(here.counts, held_out, row_use::held_out), unseen_stretches);
    if (made.unseen_with.size() >= stretches_wanted) {
        return made;
    }
    made.unseen_with.clear();
    made.unseen_without.clear();
    for (const held_out_parts parts : {held_out_parts::odd, held_out_parts::even}) {
        block_model model(result.block, *input.fit, given, events.fit, parts);
        const fit_result fitted =
            fit(model, result.floor, result.extended, result.fitted.parameters, input.options.replays_max / 2);
        const two_replays there = replayed(*input.fit, events.fit, fitted.rig);
        const auto uses = uses_with_events(result.block, input, given, parts);
        add_stretches_with_events(made, there, both(there.counts, uses, row_use::held_out), unseen_stretches / 2);
    }
    return made;
}

} // namespace berth
