#include "loss_trace.h"

#include <algorithm>
#include <cmath>

#include "../replay/driven_path.h"

namespace berth
{

loss_trace trace_of_loss(const block_model &model, const rig &given)
{
    const rig rig = that_follows_setpoints(given);
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
    loss_trace made{0, {}};
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

} // namespace berth
