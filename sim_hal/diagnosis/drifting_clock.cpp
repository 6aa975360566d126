#include "drifting_clock.h"

#include <algorithm>
#include <cmath>

namespace berth
{

namespace
{

/* Mean lateness of a part of the record, from error = -late velocity, and how well it is known. */
struct lateness {
    double time_s;
    double late_s;
    double weight;
};

std::vector<lateness> lateness_over_time(const std::vector<double> &error, const std::vector<double> &position_m,
                                         double period_s)
{
    const std::size_t length = std::max<std::size_t>(10, static_cast<std::size_t>(0.2 / period_s));
    std::vector<lateness> parts;
    parts.reserve(error.size() / length);
    for (std::size_t begin = 1; begin + length < error.size(); begin += length) {
        double both = 0.0;
        double square = 0.0;
        for (std::size_t n = begin; n < begin + length; n++) {
            const double velocity = (position_m[n + 1] - position_m[n - 1]) / (2.0 * period_s);
            both -= error[n] * velocity;
            square += velocity * velocity;
        }
        if (square > 0.0) {
            const double middle = static_cast<double>(begin) + 0.5 * static_cast<double>(length);
            parts.push_back({middle * period_s, both / square, square});
        }
    }
    return parts;
}

/* Weighted square of what a sawtooth leaves; its mean is free, as the dead time is. */
double left_by(const std::vector<lateness> &parts, double drift, double phase_s, double period_s)
{
    double weight = 0.0;
    double sum = 0.0;
    double square = 0.0;
    for (const lateness &part : parts) {
        const double way = (phase_s + drift * part.time_s) / period_s;
        const double rest = part.late_s - period_s * (way - std::floor(way));
        weight += part.weight;
        sum += part.weight * rest;
        square += part.weight * rest * rest;
    }
    return weight > 0.0 ? square - sum * sum / weight : 0.0;
}

} // namespace

std::vector<clock_guess> drifting_clocks(const std::vector<double> &error, const std::vector<double> &position_m,
                                         double period_s, int count)
{
    constexpr int wraps_max = 30; /* of the sawtooth over the record, either way */
    constexpr int steps_a_wrap = 8;
    constexpr int phases = 16;
    const std::vector<lateness> parts = lateness_over_time(error, position_m, period_s);
    struct trial {
        clock_guess guess;
        double left;
    };
    std::vector<trial> trials;
    constexpr std::size_t drifts = 2 * wraps_max * steps_a_wrap + 1;
    trials.reserve(drifts);
    const double duration_s = period_s * static_cast<double>(error.size());
    for (int i = -wraps_max * steps_a_wrap; i <= wraps_max * steps_a_wrap; i++) {
        const double drift = i * period_s / (steps_a_wrap * duration_s);
        trial best{{}, unlimited};
        for (int k = 0; k < phases; k++) {
            const double phase_s = (k + 0.5) * period_s / phases;
            const double left = left_by(parts, drift, phase_s, period_s);
            if (left < best.left) {
                best = {{1e6 * drift, 1e3 * phase_s}, left};
            }
        }
        if (i != 0) {
            trials.push_back(best);
        }
    }
    std::sort(trials.begin(), trials.end(), [](const trial &a, const trial &b) { return a.left < b.left; });
    std::vector<clock_guess> guesses;
    for (std::size_t i = 0; i < trials.size() && i < static_cast<std::size_t>(count); i++) {
        guesses.push_back(trials[i].guess);
    }
    return parts.empty() ? std::vector<clock_guess>{} : guesses;
}

} // namespace berth
