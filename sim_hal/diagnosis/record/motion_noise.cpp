#include "motion_noise.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "../replay/other_input.h"
#include "measured_motion.h"

namespace berth
{

double motion_noise_m(const record &data)
{
    constexpr double weights[] = {1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0};
    constexpr double weights_norm = 30.397368307; /* root of the sum of their squares, 924 */
    constexpr double median_of_normal = 0.67449;  /* of its size, in standard deviations */
    const std::vector<double> &x_m = data.robot_position_m;
    std::vector<double> sizes_m;
    for (const record_segment &part : data.segments) {
        for (std::size_t n = part.begin; n + std::size(weights) <= part.end; n++) {
            double difference_m = 0.0;
            for (std::size_t i = 0; i < std::size(weights); i++) {
                difference_m += weights[i] * x_m[n + i];
            }
            sizes_m.push_back(std::abs(difference_m));
        }
    }
    const double of_steps_m = lattice_step(data.known(x_m)) / std::sqrt(12.0);
    if (sizes_m.empty()) {
        return of_steps_m;
    }
    return std::max(of_steps_m, median_of(std::move(sizes_m)) / (median_of_normal * weights_norm));
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
