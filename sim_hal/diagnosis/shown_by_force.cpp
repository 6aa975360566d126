#include "shown_by_force.h"

#include <algorithm>
#include <iterator>
#include <utility>

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
    now.error_before = before.error_before;
    for (const auto rms : {&block_diagnosis::fit_rms, &block_diagnosis::held_out_rms}) {
        (now.*rms).before = (before.*rms).before;
        (now.*rms).retuned = (before.*rms).retuned;
    }
}

} // namespace

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
