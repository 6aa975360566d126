#include "motion_noise.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "../noise/lattice_step.h"
#include "../replay/other_input.h"
#include "measured_motion.h"

namespace berth
{

double noise_from_row_to_row(const record &data, const std::vector<double> &column)
{
    constexpr double weights[] = {1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0};
    constexpr double weights_norm = 30.397368307; /* root of the sum of their squares, 924 */
    constexpr double median_of_normal = 0.67449;  /* of its size, in standard deviations */
    std::vector<double> sizes;
    for (const record_segment &part : data.segments) {
        for (std::size_t n = part.begin; n + std::size(weights) <= part.end; n++) {
            double difference = 0.0;
            for (std::size_t i = 0; i < std::size(weights); i++) {
                difference += weights[i] * column[n + i];
            }
            sizes.push_back(std::abs(difference));
        }
    }
    const double of_steps = lattice_step(data.known(column)) / std::sqrt(12.0);
    if (sizes.empty()) {
        return of_steps;
    }
    return std::max(of_steps, median_of(std::move(sizes)) / (median_of_normal * weights_norm));
}

double motion_noise_m(const record &data)
{
    return noise_from_row_to_row(data, data.robot_position_m);
}

double force_of_motion_noise_N(const record &data, const rig &rig, const sample_events &events)
{
    if (!data.moves_as_measured()) {
        return 0.0;
    }
    record noisier = data;
    std::mt19937 engine(1); /* the same record gives the same note */
    const double as_uniform_m = motion_noise_m(data) * std::sqrt(12.0);
    for (double &value_m : noisier.robot_position_m) {
        value_m += as_uniform_m * (static_cast<double>(engine()) / 4294967296.0 - 0.5);
    }
    noisier.command_position_m.clear();
    drive_by_measured_motion(noisier);
    return rms_of_other_input(block::force, data, noisier, rig, events);
}

} // namespace berth
