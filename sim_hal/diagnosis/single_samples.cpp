#include "single_samples.h"

#include <algorithm>

#include "floor.h"
#include "lost_commands.h"

namespace berth
{

void find_single_samples(block block, const diagnosis_input &input, const rig &given, sample_events &events,
                         std::vector<event_finding> &found)
{
    const sample_events before = events;
    rig base = given;
    std::vector<double> error;
    for (int pass = 0; pass < 2; pass++) {
        std::vector<event_finding> now;
        block_model model(block, *input.fit, given, events, held_out_parts::none);
        model.error(base, error);
        base = fit(model, noise_of(model, error, true), base, joined(input.upstream, base_parameters(block, given)),
                   input.options.replays_max)
                   .rig;
        events = before;
        block_model plain(block, *input.fit, given, events, held_out_parts::none);
        plain.error(base, error);
        if (block != block::manipulator && given.robot.clock == robot_clock::locked) {
            now = find_lost_commands(plain, base, error, events);
        }
        if (block == block::robot && !now.empty() && can_replay(*input.fit, block::force)) {
            block_model force(block::force, *input.fit, given, before, held_out_parts::none);
            if (!force_knows_of(force, base, events)) {
                events = before; /* samples that were not taken, rather than setpoints */
                now.clear();
            }
        }
        /* Where the robot jumps at another tick than ours, a stiff contact has a spike that is none. */
        const bool may_jump = input.without_switching_fault != nullptr || input.options.robot_in_force;
        if (block == block::force && now.empty() && !may_jump) {
            now = find_spikes(plain, error, events);
        }
        if (now.empty()) {
            return;
        }
        if (pass == 1) {
            found.insert(found.end(), now.begin(), now.end());
        }
    }
}

void verify_spikes(block block, const diagnosis_input &input, block_diagnosis &result, sample_events &events,
                   std::vector<event_finding> &found)
{
    const auto spikes = std::find_if(found.begin(), found.end(),
                                     [](const event_finding &one) { return one.effect->name == "sensor.spikes"; });
    if (block != block::force || spikes == found.end()) {
        return;
    }
    sample_events without = events;
    without.spike.clear();
    block_model model(block, *input.fit, result.extended, without, held_out_parts::none);
    std::vector<double> error;
    model.error(result.extended, error);
    const std::vector<event_finding> again = find_spikes(model, error, without);
    if (again.empty() || 2 * again[0].count < spikes->count) {
        found.erase(spikes);
        events.spike.clear();
    } else {
        *spikes = again[0];
    }
}

} // namespace berth
