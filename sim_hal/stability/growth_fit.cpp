#include "growth_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace berth
{

namespace
{

constexpr std::size_t least_extremes = 8;

/* What the scatter of the heights does not show: parabolas at few samples a period, steps of the wire. Measured on
 * the reference cases against their eigenvalues: 1.6e-5 at 400 Hz, 4.7e-5 at 50 Hz; doubled. */
constexpr double systematic = 1e-4;

struct extreme {
    double time_s;
    double value;
};

struct straight_line {
    double slope;
    double slope_deviation;
    double mean_x; /* the line passes through the means */
    double mean_y;

    double at(double x) const { return mean_y + slope * (x - mean_x); }
};

std::vector<extreme> find_extremes(const std::vector<double> &signal, double period_s)
{
    std::vector<extreme> extremes;
    for (std::size_t i = 1; i + 1 < signal.size(); i++) {
        const std::size_t first = i;
        const double before = signal[first] - signal[first - 1];
        while (i + 2 < signal.size() && signal[i + 1] == signal[i]) {
            i++; /* an extreme may be flat, and be it for two equal samples to either side of it */
        }
        const double after = signal[i + 1] - signal[i];
        if (before * after < 0.0) {
            const double middle = 0.5 * static_cast<double>(first + i);
            const double shift = i > first ? 0.0 : -0.5 * (after + before) / (after - before); /* in samples */
            extremes.push_back({(middle + shift) * period_s, signal[i] + 0.5 * shift * (0.5 * (after + before))});
        }
    }
    return extremes;
}

/* Drops swings that are small beside both their neighbours: wiggles of noise on the way from one extreme of the
 * oscillation to the next. A decaying or growing oscillation has no such swings. */
std::vector<extreme> without_wiggles(const std::vector<extreme> &all)
{
    constexpr double small = 0.95;
    std::vector<extreme> kept;
    for (const extreme &next : all) {
        kept.push_back(next);
        while (kept.size() >= 4) {
            const extreme *const last = &kept[kept.size() - 4];
            const auto swing = [&](int i) { return std::abs(last[i + 1].value - last[i].value); };
            if (swing(1) >= small * std::min(swing(0), swing(2))) {
                break;
            }
            kept.erase(kept.end() - 3, kept.end() - 1);
        }
    }
    return kept;
}

template <typename X, typename Y, typename W>
straight_line fit_line(std::size_t count, X x_of, Y y_of, W weight_of)
{
    double weight = 0.0;
    double mean_x = 0.0;
    double mean_y = 0.0;
    for (std::size_t i = 0; i < count; i++) {
        weight += weight_of(i);
        mean_x += weight_of(i) * x_of(i);
        mean_y += weight_of(i) * y_of(i);
    }
    mean_x /= weight;
    mean_y /= weight;
    double xx = 0.0;
    double xy = 0.0;
    double yy = 0.0;
    for (std::size_t i = 0; i < count; i++) {
        const double x = x_of(i) - mean_x;
        const double y = y_of(i) - mean_y;
        xx += weight_of(i) * x * x;
        xy += weight_of(i) * x * y;
        yy += weight_of(i) * y * y;
    }
    const double slope = xy / xx;
    const double unexplained = std::max(0.0, yy - slope * xy);
    return {slope, std::sqrt(unexplained / (static_cast<double>(count) - 2.0) / xx), mean_x, mean_y};
}

double median(std::vector<double> values)
{
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

/* Heights that rise or fall evenly are a mode's, slower than what was before it, and not noise. Of 1500 decays into
 * noise that swings with a damping ratio of 0.02 or 0.05, 4 ended evenly by chance. */
bool is_even(const oscillation_height *heights, std::size_t count)
{
    constexpr double even = 0.05;   /* deviation from an exponential, as a share of the height */
    constexpr double clearly = 4.0; /* deviations of the slope */
    const auto time_s = [&](std::size_t i) { return heights[i].time_s; };
    const auto logarithm = [&](std::size_t i) { return std::log(heights[i].value); };
    const straight_line line = fit_line(count, time_s, logarithm, [](std::size_t) { return 1.0; });
    double square = 0.0;
    for (std::size_t i = 0; i < count; i++) {
        square += std::pow(logarithm(i) - line.at(time_s(i)), 2.0);
    }
    return std::sqrt(square / static_cast<double>(count)) < even &&
           std::abs(line.slope) > clearly * line.slope_deviation;
}

/* The level of a signal that decays no more at its end (noise keeps it going), else 0. */
double settled_level(const std::vector<oscillation_height> &heights)
{
    const std::size_t part = heights.size() / 4;
    if (part < least_extremes) {
        return 0.0;
    }
    const auto is_lower = [](const auto &a, const auto &b) { return a.value < b.value; };
    const auto level_of = [&](std::size_t from) {
        std::vector<double> values;
        for (std::size_t i = from; i < from + part; i++) {
            values.push_back(heights[i].value);
        }
        return median(values);
    };
    const double first = level_of(0);
    const double second = level_of(part);
    const double third = level_of(heights.size() - 2 * part);
    const double last = level_of(heights.size() - part);
    const double start = std::max_element(heights.begin(), heights.begin() + least_extremes, is_lower)->value;
    /* An exponential loses the same share from quarter to quarter, and if that is little it has not come far. */
    const bool has_settled =
        (last < 0.3 * first && last / third > 1.5 * (second / first)) || (last < 0.25 * start && last / third > 0.7);
    return has_settled && !is_even(&heights[heights.size() - part], part) ? last : 0.0;
}

/* By how much a quarter's slope is off that of all. Where two modes swing, their beats and the knee from the faster
 * one's decay to the slower one's are no scatter: what the slower one does may only show in a quarter. Slopes that
 * go one way through all four may be on their way to it yet: as far again as from the third to the last. */
template <typename W>
double farthest_quarter(const std::vector<oscillation_height> &heights, double slope, W weight_of)
{
    constexpr std::size_t least_of_quarter = 4;
    const std::size_t part = heights.size() / 4;
    if (part < least_of_quarter) {
        return 0.0;
    }
    std::array<double, 4> off{};
    for (std::size_t i = 0; i < off.size(); i++) {
        const std::size_t from = i * part;
        const straight_line own = fit_line(
            part, [&](std::size_t j) { return heights[from + j].time_s; },
            [&](std::size_t j) { return std::log(heights[from + j].value); },
            [&](std::size_t j) { return weight_of(from + j); });
        off[i] = own.slope - slope;
    }
    const auto is_smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
    const double farthest = std::abs(*std::max_element(off.begin(), off.end(), is_smaller));
    const bool goes_on = std::is_sorted(off.begin(), off.end()) || std::is_sorted(off.rbegin(), off.rend());
    return goes_on ? std::max(farthest, std::abs(2.0 * off[3] - off[2])) : farthest;
}

} // namespace

std::vector<oscillation_height> oscillation_heights(const std::vector<double> &signal, double period_s)
{
    const std::vector<extreme> extremes = without_wiggles(find_extremes(signal, period_s));
    std::vector<oscillation_height> heights;
    for (std::size_t i = 1; i < extremes.size(); i++) {
        heights.push_back({0.5 * (extremes[i].time_s + extremes[i - 1].time_s),
                           std::abs(extremes[i].value - extremes[i - 1].value)});
    }
    return heights;
}

std::optional<growth_fit> fit_growth(const std::vector<double> &signal, double period_s, double floor)
{
    std::vector<oscillation_height> heights = oscillation_heights(signal, period_s);
    const double noise = settled_level(heights);
    const double lowest = std::max(floor, 4.0 * noise);
    const auto first_low = std::find_if(heights.begin(), heights.end(),
                                        [&](const oscillation_height &height) { return height.value < lowest; });
    heights.erase(first_low, heights.end());
    heights.erase(heights.begin(), heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 4));
    if (heights.size() < least_extremes) {
        return {};
    }
    const auto time_s = [&](std::size_t i) { return heights[i].time_s; };
    const auto number = [](std::size_t i) { return static_cast<double>(i); };
    const auto logarithm = [&](std::size_t i) { return std::log(heights[i].value); };
    /* Noise of a given level disturbs the logarithm of a height in proportion to noise / height. */
    const auto weight = [&](std::size_t i) {
        return noise > 0.0 ? heights[i].value * heights[i].value / (noise * noise) : 1.0;
    };
    const straight_line growth = fit_line(heights.size(), time_s, logarithm, weight);
    const std::size_t half = heights.size() / 2;
    const straight_line early = fit_line(half, time_s, logarithm, weight);
    const auto later = [half](auto of) { return [of, half](std::size_t i) { return of(half + i); }; };
    const straight_line late = fit_line(heights.size() - half, later(time_s), later(logarithm), later(weight));
    const double quarters_off_per_s = farthest_quarter(heights, growth.slope, weight);
    const straight_line half_period_s = fit_line(heights.size(), number, time_s, [](std::size_t) { return 1.0; });
    const double from_s = heights.front().time_s;
    const double deviation_per_s = std::hypot(
        std::max({1.96 * growth.slope_deviation, 0.5 * std::abs(late.slope - early.slope), quarters_off_per_s}),
        systematic * growth.slope);
    return growth_fit{growth.slope,  deviation_per_s,       0.5 / half_period_s.slope,
                      from_s,        heights.back().time_s, std::exp(growth.at(from_s)),
                      heights.size()};
}

} // namespace berth
