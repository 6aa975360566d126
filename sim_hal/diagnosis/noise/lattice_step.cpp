#include "lattice_step.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <Eigen/Core>
#include <map>

#include "../../../firmware/pi.h"

namespace berth
{

namespace
{

bool are_multiples_of(double step, const std::vector<double> &changes, std::size_t odd_most)
{
    constexpr double loose = 0.25; /* of a step: half of what lies anywhere would be as near */
    std::size_t odd = 0;
    for (const double change : changes) {
        const double steps = change / step;
        odd += std::abs(steps - std::round(steps)) > std::min(loose, 0.01 + 1e-4 * steps);
        if (odd > odd_most) {
            return false;
        }
    }
    return true;
}

/* Fine or coarse, but exact. */
double exact_step(const std::vector<double> &values)
{
    std::vector<double> changes;
    for (std::size_t n = 1; n < values.size(); n++) {
        if (values[n] != values[n - 1]) {
            changes.push_back(std::abs(values[n] - values[n - 1]));
        }
    }
    /* One in a hundred may lie off the steps, as a first value before all is set up: the smallest changes may be
     * theirs. Two of about one size are tried once. */
    const std::size_t odd_most = values.size() / 100;
    std::vector<double> smallest(std::min(changes.size(), 1 + odd_most));
    std::partial_sort_copy(changes.begin(), changes.end(), smallest.begin(), smallest.end());
    double tried = 0.0;
    for (const double step : smallest) {
        if (step > 1.001 * tried && are_multiples_of(step, changes, odd_most)) {
            return step;
        }
        tried = step;
    }
    return 0.0;
}

/* Of changes a quarter of a step from a whole number of steps, or nearer, half are so by chance. */
constexpr double near_steps = 0.25;

/* Of a step that is `step` or a little more or less: by least squares over the changes that are few of them. */
double adjusted(double step, const std::vector<double> &changes)
{
    constexpr double few = 10.0;
    double sum = 0.0;
    double square = 0.0;
    for (const double change : changes) {
        const double steps = std::round(change / step);
        if (steps <= few && std::abs(change / step - steps) < near_steps) {
            sum += change * steps;
            square += steps * steps;
        }
    }
    return square > 0.0 ? sum / square : step;
}

/* The signal stays where it is or goes on by whole steps, and does both often. */
bool goes_by(double step, const std::vector<double> &changes)
{
    constexpr double nearly_all = 0.9;
    constexpr double of_those_that_go = 0.8;
    constexpr double rests_least = 0.1;
    constexpr double goes_least = 0.05;
    double near = 0.0;
    double goes = 0.0;
    double goes_near = 0.0;
    for (const double change : changes) {
        const double steps = std::round(change / step);
        const bool is_near = std::abs(change / step - steps) < near_steps;
        near += is_near;
        goes += steps > 0.0;
        goes_near += is_near && steps > 0.0;
    }
    const auto all = static_cast<double>(changes.size());
    return near >= nearly_all * all && goes_near >= of_those_that_go * goes && goes >= goes_least * all &&
           goes <= (1.0 - rests_least) * all;
}

/* Mean of exp(2 pi i x / step): its size is 1 on the steps, about 0 for values that lie anywhere, and
 * exp(-2 (pi sd / step)^2) with noise of that standard deviation upon them. */
std::complex<double> phase_about(double step, const std::vector<double> &values)
{
    std::complex<double> sum = 0.0;
    for (const double value : values) {
        sum += std::polar(1.0, 2.0 * pi * value / step);
    }
    return sum / static_cast<double>(values.size());
}

/* Slope of the values over their levels, by least squares. */
double step_through(const std::vector<double> &level, const std::vector<double> &values)
{
    const auto size = static_cast<Eigen::Index>(values.size());
    const Eigen::ArrayXd levels = Eigen::Map<const Eigen::ArrayXd>(level.data(), size);
    const Eigen::ArrayXd off = levels - levels.mean();
    return (off * Eigen::Map<const Eigen::ArrayXd>(values.data(), size)).sum() / off.square().sum();
}

/* Besides those on the most frequent level, where a signal rests, and at its ends, where a limit holds it. */
bool are_on_levels(const std::vector<double> &level, const std::vector<double> &values, double step)
{
    constexpr double on_them = 0.75;
    constexpr double enough = 0.05;
    const auto [lowest, highest] = std::minmax_element(level.begin(), level.end());
    std::map<double, std::size_t> rows_on;
    for (const double one : level) {
        rows_on[one]++;
    }
    const auto rest = std::max_element(rows_on.begin(), rows_on.end(),
                                       [](const auto &a, const auto &b) { return a.second < b.second; });
    std::vector<double> others;
    for (std::size_t n = 0; n < values.size(); n++) {
        if (level[n] != *lowest && level[n] != *highest && level[n] != rest->first) {
            others.push_back(values[n]);
        }
    }
    return static_cast<double>(others.size()) > enough * static_cast<double>(values.size()) &&
           std::abs(phase_about(step, others)) > on_them;
}

/* The values, and not their changes alone, as those of a spike are, lie on several levels: the step with which they
 * do so best. */
double step_of_levels(double step, const std::vector<double> &values)
{
    constexpr double uncertain = 0.01; /* of the step, as `adjusted` knows it from the changes */
    constexpr double levels_max = 2000.0;
    const auto [least, largest] = std::minmax_element(values.begin(), values.end());
    const double levels = (*largest - *least) / step;
    if (levels > levels_max) {
        return 0.0;
    }
    const auto trials = static_cast<int>(std::ceil(4.0 * uncertain * levels));
    double best = step;
    double most = 0.0;
    for (int trial = -trials; trial <= trials; trial++) {
        const double tried = step * (1.0 + uncertain * trial / std::max(1, trials));
        const double on_levels = std::abs(phase_about(tried, values));
        if (on_levels > most) {
            most = on_levels;
            best = tried;
        }
    }
    const std::complex<double> phase = phase_about(best, values);
    const double offset = std::arg(phase) / (2.0 * pi) * best;
    std::vector<double> level(values.size());
    std::transform(values.begin(), values.end(), level.begin(),
                   [&](double value) { return std::round((value - offset) / best); });
    return are_on_levels(level, values, best) ? step_through(level, values) : 0.0;
}

/* Coarse, with values off the steps or noise upon them. */
double coarse_step(const std::vector<double> &values)
{
    constexpr std::size_t looked_at = 800;
    constexpr std::size_t least = 100;
    constexpr std::size_t tries = 16;
    if (values.size() < least) {
        return 0.0;
    }
    const std::size_t every = 1 + values.size() / looked_at;
    std::vector<double> some;
    std::vector<double> changes;
    for (std::size_t n = 1; n < values.size(); n += every) {
        some.push_back(values[n]);
        changes.push_back(std::abs(values[n] - values[n - 1]));
    }
    std::sort(changes.begin(), changes.end());
    for (std::size_t i = tries; i > 0; i--) { /* half a step would do as well as the whole one */
        double step = changes[(changes.size() - 1) * i / tries];
        if (step <= 0.0) {
            break;
        }
        for (int pass = 0; pass < 3; pass++) {
            step = adjusted(step, changes);
        }
        if (goes_by(step, changes)) {
            return step_of_levels(step, some);
        }
    }
    return 0.0;
}

} // namespace

double lattice_step(const std::vector<double> &values)
{
    /* With strays among them few sizes of a coarse step are multiples of many a fine one. */
    constexpr double same = 0.01;
    const double exact = exact_step(values);
    const double coarse = coarse_step(values);
    return coarse == 0.0 || std::abs(exact - coarse) < same * coarse ? exact : coarse;
}

} // namespace berth
