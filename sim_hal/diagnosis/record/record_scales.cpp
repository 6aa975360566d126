#include <algorithm>
#include <cmath>

#include "../noise/spectrum_lines.h"
#include "../replay/robot_reference.h"
#include "../samples/drifting_clock.h"
#include "../search/search.h"

namespace berth
{

namespace
{

/* Size of the error that only this share of the rows of the fit exceeds. */
double exceeded_by(const std::vector<double> &error, const std::vector<row_use> &uses, double share)
{
    std::vector<double> sizes;
    sizes.reserve(error.size());
    for (std::size_t n = 0; n < error.size(); n++) {
        if (uses[n] == row_use::fit) {
            sizes.push_back(std::abs(error[n]));
        }
    }
    if (sizes.empty()) {
        return 0.0;
    }
    const auto at =
        sizes.begin() + static_cast<std::ptrdiff_t>((1.0 - share) * static_cast<double>(sizes.size() - 1));
    std::nth_element(sizes.begin(), at, sizes.end());
    return *at;
}

} // namespace

record_scales scales_of(block_model &model, const rig &rig, const std::vector<double> &error,
                        const search_options &options)
{
    const record &record = model.data();
    record_scales scales;
    scales.period_s = record.period_s;
    scales.duration_s = record.period_s * static_cast<double>(record.size());
    (void)rig;
    const std::vector<double> &x =
        !record.command_position_m.empty() ? record.command_position_m : record.robot_position_m;
    double mean = 0.0;
    for (const double value : x) {
        mean += value / static_cast<double>(x.size());
    }
    const std::size_t step = std::max<std::size_t>(1, static_cast<std::size_t>(0.005 / record.period_s));
    double before = 0.0;
    for (const record_segment &part : record.segments) {
        for (std::size_t n = part.begin; n < part.end; n++) {
            scales.position_m = std::max(scales.position_m, std::abs(x[n] - mean));
            if (n >= part.begin + step) {
                const double rate = (x[n] - x[n - step]) / (static_cast<double>(step) * record.period_s);
                scales.velocity_m_per_s = std::max(scales.velocity_m_per_s, std::abs(rate));
                if (n > part.begin + step) {
                    scales.acceleration_m_per_s2 =
                        std::max(scales.acceleration_m_per_s2, std::abs(rate - before) / record.period_s);
                }
                before = rate;
            }
        }
    }
    for (const std::vector<double> *forces : {&record.force_N, &record.operator_force_N}) {
        const bool counts = model.which() == block::force ? forces == &record.force_N : true;
        for (std::size_t n = 0; counts && n < forces->size(); n++) {
            scales.force_N = std::max(scales.force_N, std::abs((*forces)[n]));
        }
    }
    if (scales.force_N == 0.0) {
        scales.force_N = rig.firmware.manipulator.stiffness_N_per_m * scales.position_m;
    }
    scales.residual = rms_of(error, model.uses(), row_use::fit);
    scales.residual_peak = exceeded_by(error, model.uses(), 0.005);
    const bool is_force = model.which() == block::force;
    scales.residual_m =
        is_force ? scales.residual * scales.position_m / std::max(scales.force_N, 1e-300) : scales.residual;
    scales.residual_frequency_Hz = strongest_frequency_Hz(error, record.period_s);
    if (model.which() == block::robot) {
        scales.clocks = drifting_clocks(error, model.motion().at_tick_m, record.period_s, 6);
        for (clock_guess &guess : scales.clocks) { /* that looks for setpoints that have come */
            const double period_ms = 1e3 * record.period_s;
            guess.phase_ms = std::fmod(guess.phase_ms + 1e3 * setpoint_arrival_s(rig), period_ms);
        }
    }
    if (model.which() == block::robot || options.robot_in_force) {
        scales.residual_pitch_m = strongest_pitches_m(error, model.motion().at_tick_m, 3);
    }
    return scales;
}

} // namespace berth
