#include "robot_and_force.h"

#include <algorithm>
#include <cmath>

#include "acceptance.h"
#include "floor.h"

namespace berth
{

namespace
{

bool leaves_something(const block_diagnosis &block)
{
    return block.verdict == verdict::unknown || block.verdict == verdict::partly_explained;
}

/* Something is left, and what was found are single samples at most: jumps of the robot may look like spikes. */
bool may_hide_robot(const block_diagnosis &force)
{
    return leaves_something(force) && std::all_of(force.causes.begin(), force.causes.end(), [](const cause &known) {
               return known.effect->is_of_single_samples;
           });
}

/* A limit that acts now and then, or a small dead band, hides in the noise of the robot's reports and shows in a
 * stiff contact: it is believed if the reports do not contradict. */
void look_for_hidden_robot(block_diagnosis &force, const block_diagnosis &robot, const block_start &start)
{
    constexpr double contradiction = 10.0; /* of the white sum of squares */
    diagnosis_input input = start.input;
    input.options.robot_in_force = true;
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

bool is_clearly_smaller(const block_diagnosis &other, const block_diagnosis &force)
{
    const auto rows = static_cast<double>(std::count(force.uses.begin(), force.uses.end(), row_use::fit));
    return rows * 2.0 * std::log(force.fit_rms.after / other.fit_rms.after) > bic_look_alike;
}

/* Of causes that the reports cannot tell apart one after the other is left out, until the force has nothing against
 * what they say then. */
void let_force_decide(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                      const block_start &robot_start, const block_start &force_start, const rig &as_given)
{
    constexpr int tries_max = 2;
    block_start without = robot_start;
    std::string refuted(robot.causes.back().effect->name);
    for (int i = 0; i < tries_max; i++) {
        without.input.options.without.push_back(refuted);
        events_of_records other_events = without.events;
        block_diagnosis other =
            diagnose_block(block::robot, without.input, without.given, other_events, without.found_events);
        const bool is_rival =
            !other.causes.empty() && !leaves_something(other) &&
            std::any_of(robot.alternatives.begin(), robot.alternatives.end(),
                        [&](const auto &rival) { return rival.effect == other.causes.back().effect; });
        if (!is_rival) {
            return;
        }
        diagnosis_input input = force_start.input;
        know_robot(input, other, as_given);
        block_diagnosis seen =
            diagnose_block(block::force, input, other.extended, other_events, force_start.found_events);
        if (!leaves_something(seen) && is_clearly_smaller(seen, force)) {
            robot = std::move(other);
            force = std::move(seen);
            events = std::move(other_events);
            return;
        }
        refuted = other.causes.back().effect->name;
    }
}

} // namespace

void know_robot(diagnosis_input &force, const block_diagnosis &robot, const rig &as_given)
{
    const bool switches = std::any_of(robot.causes.begin(), robot.causes.end(), [](const cause &known) {
        return known.effect->switches || known.effect->name == "robot.lost_commands";
    });
    force.upstream = robot.refinable;
    force.has_cause_upstream = !robot.causes.empty();
    force.without_switching_fault = switches ? &as_given : nullptr;
}

void ask_force_about_robot(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                           const block_start &robot_start, const block_start &force_start, const rig &as_given)
{
    if (may_hide_robot(force) && robot.causes.empty()) {
        look_for_hidden_robot(force, robot, force_start);
    } else if (leaves_something(force) && robot.verdict == verdict::one_of) {
        let_force_decide(robot, force, events, robot_start, force_start, as_given);
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

/* What is left in the robot's reports may be what the force shows more of: then they are judged anew with it. */
void judge_robot_again(block_diagnosis &robot, const block_diagnosis &force, const diagnosis_input &input,
                       events_of_records events)
{
    const bool has_more = std::any_of(force.causes.begin(), force.causes.end(),
                                      [](const cause &known) { return known.effect->block() == "robot"; });
    if (robot.block == block::robot && leaves_something(robot) && has_more) {
        const block_diagnosis again = diagnose_block(block::robot, input, force.extended, events, {});
        robot.verdict = again.causes.empty() ? again.verdict : robot.verdict;
    }
}

} // namespace berth
