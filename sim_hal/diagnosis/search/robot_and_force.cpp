#include "robot_and_force.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <utility>

#include "../../effects/active.h"
#include "../fit/base.h"
#include "../noise/floor.h"
#include "../samples/clock_ways.h"
#include "acceptance.h"
#include "rivals.h"
#include "shown_by_force.h"

namespace berth
{

bool leaves_something(const block_diagnosis &block)
{
    return block.verdict == verdict::unknown || block.verdict == verdict::partly_explained;
}

bool hardly_shows(const block_diagnosis &robot)
{
    constexpr double hardly_less = 0.9;
    return robot.fit_rms.after > hardly_less * robot.fit_rms.retuned;
}

bool is_clearly_smaller(const block_diagnosis &other, const block_diagnosis &one)
{
    const auto rows = static_cast<double>(std::count(one.uses.begin(), one.uses.end(), row_use::fit));
    return rows * 2.0 * std::log(one.fit_rms.after / other.fit_rms.after) > bic_look_alike;
}

namespace
{

constexpr std::string_view lost_commands = "robot.lost_commands";

/* What was named no more than that. */
void tell_in_part(block_diagnosis &block, std::string_view why)
{
    if (block.verdict == verdict::named || block.verdict == verdict::one_of) {
        block.verdict = verdict::partly_explained;
        block.doubts.emplace_back(why);
    }
}

bool has(const block_diagnosis &block, std::string_view effect)
{
    return std::any_of(block.causes.begin(), block.causes.end(),
                       [&](const cause &known) { return known.effect->name == effect; });
}

bool names_any_of(const block_diagnosis &block, std::initializer_list<std::string_view> names)
{
    return std::any_of(names.begin(), names.end(), [&](std::string_view name) { return has(block, name); });
}

/* Something is left, and what was found are single samples at most: jumps of the robot may look like spikes. */
bool may_hide_robot(const block_diagnosis &force)
{
    return leaves_something(force) && std::all_of(force.causes.begin(), force.causes.end(), [](const cause &known) {
               return known.effect->is_of_single_samples;
           });
}

/* A limit that acts now and then, a small dead band or error of the gears hides in the noise of the robot's reports
 * and shows in a stiff contact: it is believed if the reports do not contradict. */
void look_for_hidden_robot(block_diagnosis &force, const block_diagnosis &robot, const block_start &start)
{
    constexpr double contradiction = 10.0; /* of the white sum of squares */
    diagnosis_input input = start.input;
    input.options.robot_in_force = true;
    for (const cause &known : robot.causes) {
        input.options.without.emplace_back(known.effect->name);
    }
    events_of_records events = start.events;
    block_diagnosis again = diagnose_block(block::force, input, start.given, events, start.found_events);
    const bool is_robot = std::any_of(again.causes.begin(), again.causes.end(),
                                      [](const cause &known) { return known.effect->block() == "robot"; });
    if (!is_robot) {
        return;
    }
    block_model reports(block::robot, *input.fit, start.given, start.events.fit, held_out_parts::none);
    if (cost_of(reports, robot.floor, again.extended) < cost_of(reports, robot.floor, start.given) + contradiction) {
        force = std::move(again);
    }
}

/* Without a cause of its own, and without those that the robot's reports had brought. */
block_diagnosis force_behind_given_robot(const block_start &robot_start, const block_start &force_start,
                                         events_of_records &events)
{
    diagnosis_input input = force_start.input;
    input.effects_max = 0;
    input.upstream = base_parameters(block::robot, robot_start.given);
    input.has_cause_upstream = false;
    input.without_switching_fault = nullptr;
    return diagnose_block(block::force, input, robot_start.given, events, force_start.found_events);
}

/* Of causes that the reports cannot tell apart one after the other is left out, until the force has nothing against
 * what they say then. */
void let_force_decide(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                      const block_start &robot_start, const block_start &force_start, const rig &as_given)
{
    constexpr int tries_max = 2;
    block_start without = robot_start;
    const effect *const earlier = robot.alternatives.front().rival_of;
    std::string refuted((earlier == nullptr ? robot.causes.back().effect : earlier)->name);
    for (int i = 0; i < tries_max; i++) {
        without.input.options.without.push_back(refuted);
        events_of_records other_events = without.events;
        block_diagnosis other =
            diagnose_block(block::robot, without.input, without.given, other_events, without.found_events);
        const auto rival = std::find_if(robot.alternatives.begin(), robot.alternatives.end(),
                                        [&](const alternative &one) { return has(other, one.effect->name); });
        if (rival == robot.alternatives.end() || leaves_something(other)) {
            return;
        }
        diagnosis_input input = force_start.input;
        know_robot(input, other, as_given);
        block_diagnosis seen =
            diagnose_block(block::force, input, other.extended, other_events, force_start.found_events);
        if (!leaves_something(seen) && is_clearly_smaller(seen, force)) {
            robot = std::move(other);
            robot.force_decided = true;
            force = std::move(seen);
            events = std::move(other_events);
            return;
        }
        refuted = rival->effect->name;
    }
}

/* Than lost setpoints. */
std::ptrdiff_t other_causes(const block_diagnosis &block)
{
    return std::count_if(block.causes.begin(), block.causes.end(),
                         [](const cause &known) { return known.effect->name != lost_commands; });
}

/* Lost setpoints that the noise of the reports hides are a dead time to them, or a lag, and move the size of what
 * acts on their way: both blocks are looked at anew with those that the force has shown. */
void let_losses_explain_robot(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                              const block_start &robot_start, const block_start &force_start, const rig &as_given)
{
    events_of_records other_events = events;
    block_diagnosis other =
        diagnose_block(block::robot, robot_start.input, robot_start.given, other_events, robot_start.found_events);
    refine_thresholds(other, force_start.input, other_events);
    diagnosis_input input = force_start.input;
    know_robot(input, other, as_given);
    other_events = force_start.events;
    block_diagnosis seen =
        diagnose_block(block::force, input, other.extended, other_events, force_start.found_events);
    const bool is_simpler = other_causes(other) + other_causes(seen) < other_causes(robot) + other_causes(force);
    const bool suits_reports = is_clearly_smaller(other, robot);
    if (has(seen, lost_commands) &&
        (is_clearly_smaller(seen, force) || ((is_simpler || suits_reports) && !is_clearly_smaller(force, seen)))) {
        robot = std::move(other);
        force = std::move(seen);
        events = std::move(other_events);
    }
}

} // namespace

void know_robot(diagnosis_input &force, const block_diagnosis &robot, const rig &as_given)
{
    const bool switches = std::any_of(robot.causes.begin(), robot.causes.end(), [&](const cause &known) {
        const bool is_clock = known.effect->switch_on != nullptr;
        return is_clock ? !slip_times_s(robot.extended, *force.fit).empty()
                        : known.effect->switches || known.effect->name == lost_commands;
    });
    force.upstream = robot.refinable;
    force.has_cause_upstream = !robot.causes.empty();
    force.without_switching_fault = switches ? &as_given : nullptr;
}

void ask_force_about_robot(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                           const block_start &robot_start, const block_start &force_start, const rig &as_given)
{
    if (has(force, lost_commands)) {
        let_losses_explain_robot(robot, force, events, robot_start, force_start, as_given);
    }
    if (is_open_by_input_steps(force)) {
        return; /* what smooths a coarse command takes its steps out of the force, whatever the robot did */
    }
    const bool force_is_clear = force.verdict == verdict::nothing_detectable || force.verdict == verdict::named;
    if (robot.verdict == verdict::one_of && force_is_clear) {
        weigh_rivals_together(robot, force, events, robot_start, force_start, as_given);
    } else if (may_hide_robot(force) && robot.causes.empty()) {
        look_for_hidden_robot(force, robot, force_start);
    } else if (leaves_something(force) && !robot.alternatives.empty() && !robot.causes.empty()) {
        let_force_decide(robot, force, events, robot_start, force_start, as_given);
        if (may_hide_robot(force)) {
            look_for_hidden_robot(force, robot, force_start);
        }
    }
}

void doubt_reports(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                   const block_start &robot_start, const block_start &force_start)
{
    constexpr double no_worse = 1.02;
    if (robot.causes.empty() || force.verdict == verdict::nothing_detectable) {
        return;
    }
    events_of_records other_events = robot_start.events;
    block_diagnosis alone = force_behind_given_robot(robot_start, force_start, other_events);
    if (alone.verdict != verdict::nothing_detectable || alone.fit_rms.after > no_worse * force.fit_rms.after) {
        return;
    }
    force = std::move(alone);
    events = std::move(other_events);
    diagnosis_input input = robot_start.input;
    input.effects_max = 0;
    events_of_records own_events = robot_start.events;
    robot = diagnose_block(block::robot, input, robot_start.given, own_events, robot_start.found_events);
    robot.verdict = verdict::unknown;
    robot.doubts.insert(robot.doubts.begin(), "the force knows nothing of it: the reports are off, not the motion");
}

void doubt_tolerances(block_diagnosis &robot, block_diagnosis &force, const rig &as_given)
{
    constexpr double far = 1.5; /* tolerances: noise moves none so far */
    const auto is_far = [&](const free_parameter &known) {
        const std::string_view key = known.key->path;
        const auto &fitted = force.fitted.parameters;
        const bool is_fitted = std::any_of(fitted.begin(), fitted.end(),
                                           [&](const free_parameter &one) { return one.key->path == key; });
        const bool is_of_cause = std::any_of(robot.causes.begin(), robot.causes.end(), [&](const cause &found) {
            return std::any_of(found.effect->parameters.begin(), found.effect->parameters.end(),
                               [&](const effect_parameter &own) { return own.key == key; });
        });
        return is_fitted && !is_of_cause &&
               std::abs(value_of(force.fitted.rig, key) - known.expected) > far * known.expected_sd;
    };
    const auto base = base_parameters(block::robot, as_given);
    if (robot.causes.empty() || std::none_of(base.begin(), base.end(), is_far)) {
        return;
    }
    for (block_diagnosis *const block : {&robot, &force}) {
        tell_in_part(*block, "the force moves what is known of the robot far out of its tolerance");
    }
}

namespace
{

/* Were it the robot that is late in the way that the sensor is said to be: what stands in for the robot's own
 * lateness within the noise of its reports leaves as much in the force. */
bool reports_refute_that_late_robot(const block_diagnosis &robot, const block_diagnosis &force,
                                    const block_start &robot_start, const events_of_records &events)
{
    rig late = robot.extended;
    const double sensor_lag_ms = has(force, "sensor.lag") ? value_of_effect(force.extended, "sensor.lag_ms") : 0.0;
    const double sensor_delay_ms =
        has(force, "sensor.delay") ? force.extended.sensor.delay_ms - robot.extended.sensor.delay_ms : 0.0;
    const double lag_ms = value_of_effect(late, "robot.lag_ms");
    /* Two lags are as one of the root of the sum of their squares, but for the mean delay, which is the dead time's.
     */
    const double both_ms = std::hypot(lag_ms, sensor_lag_ms);
    set_number(late, "robot.lag_ms", both_ms);
    set_number(late, "robot.dead_time_ms", late.robot.dead_time_ms + lag_ms - both_ms + sensor_delay_ms);
    block_model reports(block::robot, *robot_start.input.fit, robot_start.given, events.fit, held_out_parts::none);
    std::vector<free_parameter> parameters;
    std::copy_if(robot.fitted.parameters.begin(), robot.fitted.parameters.end(), std::back_inserter(parameters),
                 [&](const free_parameter &known) {
                     return known.key->path != "robot.lag_ms" &&
                            (sensor_delay_ms == 0.0 || known.key->path != "robot.dead_time_ms");
                 });
    const fit_result fitted =
        fit(reports, robot.floor, late, parameters, robot_start.input.options.base_replays_max);
    return fitted.cost > cost_of(reports, robot.floor, robot.extended) + bic_undecided;
}

} // namespace

void doubt_force(block_diagnosis &robot, block_diagnosis &force, const block_start &robot_start,
                 const events_of_records &events)
{
    constexpr double well_above = 1.2; /* times the floor */
    constexpr std::string_view why = "what the robot does is not explained, and the force follows it";
    if (leaves_something(robot) && robot.fit_rms.after > well_above * robot.fit_rms.floor) {
        tell_in_part(force, why);
    }
    /* So little of the reports may stand in for what the force shows more clearly, and nothing explains there. */
    if (leaves_something(force) && force.fit_rms.after > well_above * force.fit_rms.floor &&
        other_causes(robot) > 0 && hardly_shows(robot)) {
        tell_in_part(robot, "its cause hardly shows in the reports, and the force behind it is not explained");
    }
    /* What is late in the robot the force cannot tell from what is late in the sensor. */
    if (names_any_of(robot, {"robot.dead_time", "robot.lag", "robot.resonance"}) &&
        names_any_of(force, {"sensor.delay", "sensor.lag"}) &&
        (robot.force_decided || !reports_refute_that_late_robot(robot, force, robot_start, events))) {
        tell_in_part(force,
                     "robot and sensor both have a delay or lag that the rig file does not have: within the noise "
                     "of the robot's reports, another cause in the robot would leave the same error in the force");
        if (robot.verdict == verdict::named && robot.force_decided) {
            tell_in_part(robot,
                         "its reports leave open which lateness it is, and the force follows the sensor's too");
        }
    }
    /* A floor that was found in an error which follows the robot is none, nor one that unseen data are far above. */
    constexpr double far_above = 2.0;
    const bool follows_robot =
        !force.alternatives.empty() || force.held_out_rms.after > far_above * force.fit_rms.floor;
    if (robot.verdict == verdict::partly_explained && force.verdict == verdict::nothing_detectable &&
        !force.floor_is_measured && follows_robot) {
        force.verdict = verdict::unknown;
        force.doubts.emplace_back(why);
    }
}

/* A later block saw more of an effect that an earlier one had found already. */
void drop_repeated(block_diagnosis &before, const block_diagnosis &now)
{
    const auto is_seen_again = [&](const cause &known) {
        return std::any_of(now.causes.begin(), now.causes.end(),
                           [&](const cause &seen) { return seen.effect == known.effect; });
    };
    const auto kept = std::remove_if(before.causes.begin(), before.causes.end(), is_seen_again);
    if (kept != before.causes.end() && kept == before.causes.begin() && before.verdict == verdict::named) {
        before.verdict = verdict::nothing_detectable;
    }
    before.causes.erase(kept, before.causes.end());
}

void take_refined(block_diagnosis &before, const block_diagnosis &now, const rig &given)
{
    const auto refine = [&](parameter_estimate &known, bool decides_by_ticks) {
        for (std::size_t i = 0; i < now.fitted.ci95.size(); i++) {
            if (now.fitted.parameters[i].key->path == known.key) {
                /* Slopes know nothing of the tick at which a clock slips. */
                const double ci95 = decides_by_ticks ? known.ci95 : now.fitted.ci95[i];
                known = {known.key, value_of(now.fitted.rig, known.key), ci95};
            }
        }
    };
    for (parameter_estimate &known : before.base) {
        refine(known, false);
    }
    for (cause &found : before.causes) {
        for (parameter_estimate &known : found.parameters) {
            refine(known, found.effect->switch_on != nullptr);
        }
        const parameter_estimate &size = found.parameters.front();
        if (std::abs(size.value) < size.ci95 && value_of(given, size.key) == 0.0) {
            tell_in_part(before, "beside what the force shows, the size of a cause may be none");
        }
    }
}

void measure_again(block_diagnosis &before, const rig &refined, const diagnosis_input &input,
                   const events_of_records &events)
{
    block_model model(before.block, *input.fit, refined, events.fit, held_out_parts::none);
    model.error(refined, before.error_after);
    before.fit_rms.after = rms_of(before.error_after, before.uses, row_use::fit);
    if (input.validation == nullptr) {
        before.held_out_rms.after = rms_of(before.error_after, before.uses, row_use::held_out);
    } else {
        block_model unseen(before.block, *input.validation, refined, events.unseen, held_out_parts::none);
        std::vector<double> error;
        unseen.error(refined, error);
        before.held_out_rms.after = rms_of(error, unseen.uses(), row_use::fit);
    }
}

/* What is left in the robot's reports may be what the force shows more of: then they are judged anew with it. */
void judge_robot_again(block_diagnosis &robot, const block_diagnosis &force, const diagnosis_input &input,
                       events_of_records events)
{
    const bool has_more = std::any_of(force.causes.begin(), force.causes.end(),
                                      [](const cause &known) { return known.effect->block() == "robot"; });
    if (robot.block == block::robot && leaves_something(robot) && has_more) {
        const block_diagnosis again = diagnose_block(block::robot, input, force.extended, events, {});
        const bool is_more_told = std::any_of(again.causes.begin(), again.causes.end(),
                                              [&](const cause &known) { return !has(force, known.effect->name); });
        if (is_more_told) {
            return;
        }
        robot.doubts = again.doubts;
        if (robot.causes.empty()) {
            robot.verdict = again.verdict;
        } else if (again.verdict == verdict::nothing_detectable) {
            robot.verdict = verdict::named;
        }
    }
}

} // namespace berth
