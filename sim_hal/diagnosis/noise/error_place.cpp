#include "error_place.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>

#include "../../../firmware/pi.h"
#include "fourier.h"

namespace berth
{

namespace
{

using signal = std::vector<double>;

signal change(const signal &x)
{
    signal rate(x.size(), 0.0);
    for (std::size_t n = 0; n < x.size(); n++) {
        const std::size_t before = n > 0 ? n - 1 : n;
        const std::size_t after = std::min(n + 1, x.size() - 1);
        rate[n] = after > before ? (x[after] - x[before]) / static_cast<double>(after - before) : 0.0;
    }
    return rate;
}

signal in_use(const signal &x, const std::vector<row_use> &uses)
{
    signal kept;
    for (std::size_t n = 0; n < x.size(); n++) {
        if (uses[n] != row_use::none) {
            kept.push_back(x[n]);
        }
    }
    return kept;
}

/* Rows of a window: enough for eight that overlap by half. */
std::size_t window_rows(std::size_t rows)
{
    return std::min<std::size_t>(2048, std::max<std::size_t>(16, 2 * rows / 9));
}

/* Welch's estimate with Hann windows: power per Hz at multiples of 1 / (rows * period), from the first on. */
signal power_density(const signal &error, double period_s)
{
    const std::size_t rows = window_rows(error.size());
    signal power(rows / 2, 0.0);
    double parts = 0.0;
    double square = 0.0;
    for (std::size_t begin = 0; begin == 0 || begin + rows <= error.size(); begin += rows / 2) {
        signal part(rows, 0.0);
        square = 0.0;
        for (std::size_t n = 0; n < rows; n++) {
            const double window =
                0.5 - 0.5 * std::cos(two_pi * static_cast<double>(n) / static_cast<double>(rows - 1));
            part[n] = begin + n < error.size() ? window * error[begin + n] : 0.0;
            square += window * window;
        }
        const std::vector<std::complex<double>> lines = spectrum_of(part);
        for (std::size_t k = 0; k < power.size(); k++) {
            power[k] += std::norm(lines[k + 1]);
        }
        parts += 1.0;
    }
    for (std::size_t k = 0; k < power.size(); k++) {
        const bool has_mirror_image = 2 * (k + 1) != rows;
        power[k] *= (has_mirror_image ? 2.0 : 1.0) * period_s / (parts * square);
    }
    return power;
}

/* Power per Hz of the floor's autoregressive noise. */
double floor_density(const noise_model &noise, double frequency_Hz, double period_s)
{
    std::complex<double> filtered = 1.0;
    for (std::size_t k = 0; k < noise.ar.size(); k++) {
        filtered -= noise.ar[k] * std::polar(1.0, -two_pi * frequency_Hz * period_s * static_cast<double>(k + 1));
    }
    return 2.0 * period_s * noise.sigma * noise.sigma / std::norm(filtered);
}

std::optional<frequency_band> band_of_excess(const signal &error, const noise_model &floor, double period_s)
{
    signal excess = power_density(error, period_s);
    const double step_Hz = 1.0 / (static_cast<double>(window_rows(error.size())) * period_s);
    for (std::size_t k = 0; k < excess.size(); k++) {
        const double frequency_Hz = static_cast<double>(k + 1) * step_Hz;
        excess[k] = std::max(0.0, excess[k] - floor_density(floor, frequency_Hz, period_s));
    }
    std::partial_sum(excess.begin(), excess.end(), excess.begin());
    const double all = excess.back();
    if (!(all > 0.0)) {
        return {};
    }
    const auto reached = [&](double share) {
        const auto found = std::lower_bound(excess.begin(), excess.end(), share * all);
        return static_cast<double>(found - excess.begin() + 1) * step_Hz;
    };
    return frequency_band{reached(0.1), reached(0.9)};
}

/* What an error may depend on, and words for the rows with the largest and the smallest values of it. */
struct state {
    std::string_view large;
    std::string_view small;
    signal values;
};

std::vector<state> states_of(const block_diagnosis &block, const record &data)
{
    const signal &moved = data.command_position_m.empty() ? data.robot_position_m : data.command_position_m;
    const signal position = in_use(moved, block.uses);
    const signal velocity = in_use(change(moved), block.uses);
    const signal acceleration = change(velocity);
    const double middle = median_of(position);
    const auto map = [](const signal &x, auto function) {
        signal made(x.size());
        std::transform(x.begin(), x.end(), made.begin(), function);
        return made;
    };
    const auto size = [](double x) { return std::abs(x); };
    return {{"farthest from the middle position", "nearest to the middle position",
             map(position, [&](double x) { return std::abs(x - middle); })},
            {"with the fastest motion", "with the slowest motion", map(velocity, size)},
            {"fastest on the way up", "fastest on the way down", velocity},
            {"with the strongest acceleration", "with the weakest acceleration", map(acceleration, size)},
            {"at the highest positions", "at the lowest positions", position},
            {"at the end of the record", "at the start of the record", in_use(data.time_s, block.uses)}};
}

double quantile(signal values, double share)
{
    const double at = share * static_cast<double>(values.size() - 1);
    const auto below = values.begin() + static_cast<std::ptrdiff_t>(at);
    std::nth_element(values.begin(), below, values.end());
    const double low = *below;
    const auto above = below + 1 == values.end() ? below : std::min_element(below + 1, values.end());
    return low + (at - std::floor(at)) * (*above - low);
}

} // namespace

error_place find_error_place(const block_diagnosis &block, const record &data)
{
    const signal error = in_use(block.error_after, block.uses);
    error_place place;
    if (error.size() < 2) {
        return place;
    }
    place.band = band_of_excess(error, block.floor, data.period_s);
    const double all = std::max(1e-300, sum_of_squares(error));
    for (const state &one : states_of(block, data)) {
        const double low = quantile(one.values, 0.25);
        const double high = quantile(one.values, 0.75);
        double of_small = 0.0;
        double of_large = 0.0;
        for (std::size_t n = 0; n < error.size(); n++) {
            of_small += one.values[n] <= low ? error[n] * error[n] : 0.0;
            of_large += one.values[n] >= high ? error[n] * error[n] : 0.0;
        }
        for (const auto &[words, square] :
             {std::make_pair(one.large, of_large), std::make_pair(one.small, of_small)}) {
            if (square / all > place.share) {
                place.state = words;
                place.share = square / all;
            }
        }
    }
    return place;
}

} // namespace berth
