#include "shown_by_force.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "../fit/base.h"

namespace berth
{

namespace
{

bool is_of_robot(const cause &known)
{
    return known.effect->block() == "robot" && !known.effect->is_of_single_samples;
}

/* It began with a rig that knew the cause: what the user's rig leaves is what was said before. */
void keep_as_given(block_diagnosis &now, const block_diagnosis &before)
{
    now.as_given = before.as_given;
    now.retuned = before.retuned;
    now.error_before = before.error_before;
    for (const auto rms : {&block_diagnosis::fit_rms, &block_diagnosis::held_out_rms}) {
        (now.*rms).before = (before.*rms).before;
        (now.*rms).retuned = (before.*rms).retuned;
    }
}

/* The reports are as good with the one as with the other, and the force, of whose blocks both were fitted, is not on
 * data that no fit saw. */
bool is_told_by_unseen_force(const block_diagnosis &robot, const block_diagnosis &force,
                             const block_diagnosis &other, const block_diagnosis &seen)
{
    constexpr double clear = 1.1; /* times the error; that of thousands of rows of coloured noise is known to 0.03 */
    return other.verdict == verdict::named && !is_clearly_smaller(robot, other) && !leaves_something(seen) &&
           seen.causes.size() <= force.causes.size() && !is_clearly_smaller(force, seen) &&
           force.held_out_rms.after > clear * seen.held_out_rms.after;
}

} // namespace

void refine_thresholds(block_diagnosis &robot, const diagnosis_input &input, const events_of_records &events)
{
    constexpr double clear = 0.7;  /* times the sum of squares: one more event that falls into its tick */
    constexpr double wide = 3.0;   /* times the interval */
    constexpr double widest = 0.3; /* of the size */
    for (cause &known : robot.causes) {
        parameter_estimate &size = known.parameters[0];
        if (!known.effect->switches || known.effect->block() != "robot" || !(size.ci95 > 0.0) ||
            !(size.value > 0.0)) {
            continue;
        }
        block_model force(block::force, *input.fit, robot.extended, events.fit, held_out_parts::none);
        noise_model noise;
        std::vector<double> error;
        force.error(robot.extended, error);
        noise.sigma = noise.rms = rms_of(error, force.uses(), row_use::fit);
        const auto base = base_parameters(block::force, robot.extended);
        const fit_result before = fit(force, noise, robot.extended, base, input.options.replays_max);
        const bool is_measured = !hardly_shows(robot);
        const double factor = 1.0 + (is_measured ? std::min(widest, wide * size.ci95 / size.value) : widest);
        const fit_result after = fit_rough(force, noise, *known.effect, before.rig, before, input.options, factor);
        if (after.cost < clear * before.cost) {
            size.value = value_of(after.rig, size.key);
            size.ci95 = is_measured ? std::min(size.ci95, after.ci95.back()) : after.ci95.back();
            set_number(robot.extended, size.key, size.value);
        }
    }
}

void let_unseen_force_tell_stand_in(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                                    const block_start &robot_start, const block_start &force_start,
                                    const rig &as_given)
{
    if (robot.verdict != verdict::partly_explained || robot.causes.size() != 1 || !is_of_robot(robot.causes[0])) {
        return;
    }
    block_start without = robot_start;
    without.input.options.without.emplace_back(robot.causes[0].effect->name);
    events_of_records other_events = without.events;
    block_diagnosis other =
        diagnose_block(block::robot, without.input, without.given, other_events, without.found_events);
    if (other.verdict != verdict::named) {
        return;
    }
    diagnosis_input input = force_start.input;
    know_robot(input, other, as_given);
    block_diagnosis seen =
        diagnose_block(block::force, input, other.extended, other_events, force_start.found_events);
    if (is_told_by_unseen_force(robot, force, other, seen)) {
        robot = std::move(other);
        force = std::move(seen);
        events = std::move(other_events);
    }
}

void explain_robot_beside_shown(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                                const block_start &robot_start, const block_start &force_start, const rig &as_given)
{
    std::vector<cause> shown;
    std::copy_if(force.causes.begin(), force.causes.end(), std::back_inserter(shown), is_of_robot);
    if (shown.empty() || !leaves_something(robot)) {
        return;
    }
    rig with_shown = robot_start.given;
    for (const cause &known : shown) {
        for (const parameter_estimate &parameter : known.parameters) {
            set_number(with_shown, parameter.key, parameter.value);
        }
    }
    events_of_records other_events = robot_start.events;
    block_diagnosis rest =
        diagnose_block(block::robot, robot_start.input, with_shown, other_events, robot_start.found_events);
    if (rest.causes.empty() || leaves_something(rest)) {
        return;
    }
    diagnosis_input input = force_start.input;
    know_robot(input, rest, as_given);
    input.without_switching_fault = &as_given; /* what was shown switches */
    block_diagnosis seen =
        diagnose_block(block::force, input, rest.extended, other_events, force_start.found_events);
    if (leaves_something(seen) && (!seen.causes.empty() || is_clearly_smaller(force, seen))) {
        return;
    }
    if (seen.causes.empty()) { /* what is left was judged beside what the cause explains */
        seen.verdict = force.verdict;
        seen.doubts = force.doubts;
    }
    seen.causes.insert(seen.causes.begin(), shown.begin(), shown.end());
    keep_as_given(rest, robot);
    keep_as_given(seen, force);
    robot = std::move(rest);
    force = std::move(seen);
    events = std::move(other_events);
}

} // namespace berth
