#include "floor.h"

#include <algorithm>
#include <cmath>

#include "leftover.h"
#include "spectrum_lines.h"

namespace berth
{

double precision_of(const block_model &model)
{
    const double share = model.which() == block::force ? 2e-5 : 0.0;
    double square = 0.0;
    for (const double value : model.measured()) {
        square += value * value;
    }
    return std::max(model.rounding_rms(), model.open_by_input_rms()) +
           share * std::sqrt(square / static_cast<double>(std::max<std::size_t>(1, model.measured().size())));
}

noise_model noise_of(const block_model &model, const std::vector<double> &error, bool is_white)
{
    constexpr double news_min = 0.2; /* innovation over rms; sensors have more */
    noise_model noise = is_white || model.rows_per_fact() > 1.0
                            ? estimate_noise(error, model.uses(), 0)
                            : estimate_noise_robustly(error, model.uses(), colour_of(model.which()));
    double rows_per_fact = model.rows_per_fact();
    if (noise.sigma < news_min * noise.rms) {
        constexpr double rows_max = 30.0;
        rows_per_fact = std::min(rows_max, noise.rms / noise.sigma);
        noise.ar.clear();
        noise.slow_gain = 0.0;
        noise.sigma = noise.rms;
    }
    noise.rows_per_fact = rows_per_fact;
    noise.sigma *= std::sqrt(rows_per_fact);
    return noise;
}

noise_model floor_under(block_model &model, const rig &rig)
{
    std::vector<double> error;
    model.error(rig, error);
    const std::vector<feature> features = features_of_motion(model, rig, error);
    noise_model noise = noise_of(model, error, true);
    for (int pass = 0; pass < 2; pass++) {
        std::vector<double> unexplained = unexplained_by(model, noise, features, error);
        remove_lines(unexplained, model.uses());
        noise = noise_of(model, unexplained, false);
        if (!noise.has_colour()) {
            break; /* as the first pass took it: a second one would find the same */
        }
    }
    constexpr double clearly = 1.3;
    if (noise.rms > clearly * rms_of(error, model.uses(), row_use::fit)) { /* few rows, and nearly all are motion */
        noise = noise_of_differences(error, model.uses());
    }
    return at_least(noise, precision_of(model));
}

} // namespace berth
