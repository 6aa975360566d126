#include "drifting_clock.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

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

/* A sawtooth: how many periods it drifts over the record, and which share of the way to its first slip it has behind
 * it at the start. Of a slow one, that slips once or never, the share is of the way that it goes in the record. */
struct sawtooth {
    double wraps;
    double share; /* above 1, of a slow one: no slip */
    double left = unlimited;
};

clock_guess guess_of(const sawtooth &tooth, double duration_s, double period_s)
{
    const double way = std::min(1.0, std::abs(tooth.wraps)) * tooth.share;
    const double phase = tooth.wraps > 0.0 ? 1.0 - way : way;
    return {1e6 * tooth.wraps * period_s / duration_s, 1e3 * period_s * (phase - std::floor(phase))};
}

/* Halves its steps where no neighbour is better. */
void refine(sawtooth &tooth, double wraps_step, double share_step,
            const std::function<double(const sawtooth &)> &left)
{
    constexpr int rounds = 16;
    for (int round = 0; round < rounds; round++) {
        const sawtooth here = tooth;
        for (const auto &[wraps, share] :
             {std::pair{wraps_step, 0.0}, {-wraps_step, 0.0}, {0.0, share_step}, {0.0, -share_step}}) {
            sawtooth tried{here.wraps + wraps, here.share + share};
            tried.left = left(tried);
            if (tried.left < tooth.left) {
                tooth = tried;
            }
        }
        if (tooth.left == here.left) {
            wraps_step *= 0.5;
            share_step *= 0.5;
        }
    }
}

} // namespace

std::vector<clock_guess> drifting_clocks(const std::vector<double> &error, const std::vector<double> &position_m,
                                         double period_s, int count)
{
    constexpr int wraps_max = 30; /* of the sawtooth over the record, either way */
    constexpr int steps_a_wrap = 8;
    constexpr int shares = 16;
    constexpr std::size_t refined = 24;
    const std::vector<lateness> parts = lateness_over_time(error, position_m, period_s);
    if (parts.empty()) {
        return {};
    }
    const double duration_s = period_s * static_cast<double>(error.size());
    const auto left = [&](const sawtooth &tooth) {
        const clock_guess guess = guess_of(tooth, duration_s, period_s);
        return left_by(parts, 1e-6 * guess.drift_ppm, 1e-3 * guess.phase_ms, period_s);
    };
    std::vector<double> sizes = {1.0 / 64.0, 1.0 / 32.0, 1.0 / 16.0};
    for (int i = 1; i <= wraps_max * steps_a_wrap; i++) {
        sizes.push_back(static_cast<double>(i) / steps_a_wrap);
    }
    std::vector<sawtooth> trials;
    trials.reserve(2 * sizes.size());
    for (const double size : sizes) {
        for (const double wraps : {-size, size}) {
            sawtooth best{wraps, 0.0};
            const int tried = size < 1.0 ? shares + 1 : shares; /* one without a slip */
            for (int k = 0; k < tried; k++) {
                sawtooth one{wraps, (k + 0.5) / shares};
                one.left = left(one);
                best = one.left < best.left ? one : best;
            }
            trials.push_back(best);
        }
    }
    const auto is_better = [](const sawtooth &a, const sawtooth &b) { return a.left < b.left; };
    std::sort(trials.begin(), trials.end(), is_better);
    trials.resize(std::min(trials.size(), refined));
    for (sawtooth &one : trials) {
        refine(one, 0.25 * std::abs(one.wraps) / std::max(1.0, 2.0 * std::abs(one.wraps)), 0.25 / shares, left);
    }
    std::sort(trials.begin(), trials.end(), is_better);
    std::vector<clock_guess> guesses;
    for (const sawtooth &one : trials) {
        const clock_guess guess = guess_of(one, duration_s, period_s);
        const bool is_known = std::any_of(guesses.begin(), guesses.end(), [&](const clock_guess &other) {
            return std::abs(other.drift_ppm - guess.drift_ppm) < 0.02 * std::abs(guess.drift_ppm) &&
                   std::abs(other.phase_ms - guess.phase_ms) < 20.0 * period_s; /* a fiftieth of the period */
        });
        if (!is_known && guesses.size() < static_cast<std::size_t>(count)) {
            guesses.push_back(guess);
        }
    }
    return guesses;
}

} // namespace berth
