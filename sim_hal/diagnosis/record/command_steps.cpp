#include "command_steps.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "../../hil/setpoint_step.h"
#include "../noise/lattice_step.h"
#include "../replay/other_input.h"

namespace berth
{

namespace
{

/* From row to row by little of its whole way, in most of the rows. */
bool moves_smoothly(const std::vector<double> &x)
{
    constexpr double share_of_rows = 0.05;
    constexpr double share_of_way = 0.02;
    const auto [least, most] = std::minmax_element(x.begin(), x.end());
    std::vector<double> changes;
    for (std::size_t n = 1; n < x.size(); n++) {
        if (x[n] != x[n - 1]) {
            changes.push_back(std::abs(x[n] - x[n - 1]));
        }
    }
    if (static_cast<double>(changes.size()) < share_of_rows * static_cast<double>(x.size())) {
        return false;
    }
    return median_of(changes) < share_of_way * (*most - *least);
}

/* Every value but a few is a whole number of steps away from the first one; of a step that is one by chance, a tenth
 * are. */
bool is_lattice(const std::vector<double> &x, double step)
{
    constexpr double rounding = 0.05;
    constexpr double share = 0.99;
    const auto whole = std::count_if(x.begin(), x.end(), [&](double value) {
        const double steps = (value - x.front()) / step;
        return std::abs(steps - std::round(steps)) < rounding;
    });
    return static_cast<double>(whole) > share * static_cast<double>(x.size());
}

/* As a triangle does: its way from row to row is no step of the writing. */
bool goes_at_one_rate(const std::vector<double> &x)
{
    constexpr double share = 0.95;
    constexpr double same = 1e-3;
    constexpr double few =
        0.05; /* begins and ends of rests, of the rows that move; of coarse steps there are many */
    std::vector<double> changes;
    std::size_t turns = 0;
    bool was_moving = false;
    for (std::size_t n = 1; n < x.size(); n++) {
        const double change = std::abs(x[n] - x[n - 1]);
        turns += (change > 0.0) != was_moving;
        was_moving = change > 0.0;
        if (was_moving) {
            changes.push_back(change);
        }
    }
    const double usual = median_of(changes);
    const auto alike = std::count_if(changes.begin(), changes.end(),
                                     [&](double change) { return std::abs(change - usual) < same * usual; });
    const auto count = static_cast<double>(changes.size());
    return static_cast<double>(alike) > share * count && static_cast<double>(turns) < few * count;
}

/* Means over a twentieth of a second, as far as half a step allows. */
std::vector<double> smooth_within_steps(const record &data, double step_m)
{
    const std::vector<double> &x = data.command_position_m;
    const auto side = static_cast<std::size_t>(std::max(1.0, std::round(0.025 / data.period_s)));
    std::vector<double> smooth = x;
    for (const record_segment &part : data.segments) {
        for (std::size_t n = part.begin; n < part.end; n++) {
            const std::size_t reach = std::min({side, n - part.begin, part.end - 1 - n});
            double sum = 0.0;
            for (std::size_t k = n - reach; k <= n + reach; k++) {
                sum += x[k];
            }
            const double mean = sum / static_cast<double>(2 * reach + 1);
            smooth[n] = std::clamp(mean, x[n] - 0.5 * step_m, x[n] + 0.5 * step_m);
        }
    }
    return smooth;
}

} // namespace

double command_step_m(const record &data, const rig &rig)
{
    constexpr double no_coarser = 1.5; /* times the wire's step */
    const std::vector<double> &x = data.command_position_m;
    const double step_m = x.empty() ? 0.0 : lattice_step(data.known(x));
    const bool is_coarse = step_m > no_coarser * setpoint_step_m(rig.firmware);
    return is_coarse && is_lattice(x, step_m) && moves_smoothly(x) && !goes_at_one_rate(x) ? step_m : 0.0;
}

double rms_of_command_steps(block block, const record &data, const rig &rig, const sample_events &events)
{
    const double step_m = command_step_m(data, rig);
    if (step_m == 0.0 || block == block::manipulator) {
        return 0.0;
    }
    record other = data;
    std::mt19937 engine(1); /* the same record gives the same verdict */
    for (double &value : other.command_position_m) {
        value += step_m * (static_cast<double>(engine()) / 4294967296.0 - 0.5);
    }
    return rms_of_other_input(block, data, other, rig, events);
}

bool were_steps_sent(block block, const record &data, const rig &rig, const sample_events &events)
{
    constexpr double clearly = 0.5;
    const double step_m = command_step_m(data, rig);
    if (step_m == 0.0 || block == block::manipulator) {
        return false;
    }
    record smooth = data;
    smooth.command_position_m = smooth_within_steps(data, step_m);
    const auto rms_with = [&](const record &command) {
        block_model model(block, command, rig, events, held_out_parts::none);
        std::vector<double> error;
        model.error(rig, error);
        return rms_of(error, model.uses(), row_use::fit);
    };
    return rms_with(data) < clearly * rms_with(smooth);
}

bool is_of_input_steps(double error_rms, double steps_rms, double noise_rms)
{
    constexpr double counts = 0.2; /* of the noise */
    constexpr double hardly_more = 1.1;
    return steps_rms > counts * noise_rms && error_rms < hardly_more * std::hypot(steps_rms, noise_rms);
}

} // namespace berth
