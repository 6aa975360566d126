#include "spectrum_lines.h"

#include <algorithm>
#include <cmath>
#include <complex>

#include "../../../firmware/pi.h"
#include "fourier.h"
#include "noise.h"

namespace berth
{

namespace
{

/* Amplitudes of the lines of the error less its mean, at multiples of 1 / (size * period). */
std::vector<std::complex<double>> lines_of(const std::vector<double> &error, std::size_t size)
{
    std::vector<double> padded(error);
    padded.resize(size, 0.0);
    const std::size_t used = std::min(size, error.size());
    double mean = 0.0;
    for (std::size_t n = 0; n < used; n++) {
        mean += padded[n] / static_cast<double>(used);
    }
    for (std::size_t n = 0; n < used; n++) {
        padded[n] -= mean;
    }
    return spectrum_of(padded);
}

std::size_t power_of_two_below(std::size_t count)
{
    std::size_t size = 1;
    while (size * 2 <= count) {
        size *= 2;
    }
    return size;
}

} // namespace

double strongest_frequency_Hz(const std::vector<double> &error, double period_s)
{
    const std::size_t size = 2 * power_of_two_below(error.size()); /* padded: a finer grid than the record's own */
    const auto lines = lines_of(error, size);
    std::size_t best = 0;
    for (std::size_t i = 2; i < size / 2; i++) {
        if (best == 0 || std::norm(lines[i]) > std::norm(lines[best])) {
            best = i;
        }
    }
    if (best == 0 || !(std::norm(lines[best]) > 0.0)) {
        return 0.0;
    }
    /* Parabola through the three lines about the strongest one. */
    const double left = std::abs(lines[best - 1]);
    const double middle = std::abs(lines[best]);
    const double right = std::abs(lines[best + 1]);
    const double bend = left - 2.0 * middle + right;
    const double offset = bend < 0.0 ? 0.5 * (left - right) / bend : 0.0;
    return (static_cast<double>(best) + offset) / (static_cast<double>(size) * period_s);
}

double standing_line_periods(const std::vector<double> &error)
{
    constexpr double stands_out = 60.0; /* times the median power about it: noise does once in 1e18 lines */
    constexpr std::size_t about = 40;   /* lines on either side */
    constexpr std::size_t periods_min = 5;
    const std::size_t size = power_of_two_below(error.size());
    if (size < 8 * about) {
        return 0.0;
    }
    const auto lines = lines_of(error, size);
    std::vector<double> power(size / 2);
    for (std::size_t i = 0; i < power.size(); i++) {
        power[i] = std::norm(lines[i]);
    }
    std::size_t best = 0;
    for (std::size_t i = periods_min; i < power.size(); i++) {
        const auto begin = power.begin() + static_cast<std::ptrdiff_t>(i > about ? i - about : 0);
        const auto end = power.begin() + static_cast<std::ptrdiff_t>(std::min(power.size(), i + about + 1));
        if (power[i] > *std::max_element(begin, end) * 0.999 &&
            power[i] > stands_out * median_of(std::vector<double>(begin, end)) &&
            (best == 0 || power[i] > power[best])) {
            best = i;
        }
    }
    return static_cast<double>(best) / static_cast<double>(size);
}

bool has_line(const std::vector<double> &error)
{
    return standing_line_periods(error) > 0.0;
}

namespace
{

/* Sine and cosine that fit best, and the sum of squares that they take away. */
struct wave {
    double cosine = 0.0;
    double sine = 0.0;
    double square = -1.0;
    double periods = 0.0; /* a row */
};

wave fit_wave(const std::vector<double> &x, const std::vector<row_use> &uses, double periods)
{
    double cc = 0.0;
    double cs = 0.0;
    double ss = 0.0;
    double xc = 0.0;
    double xs = 0.0;
    for (std::size_t n = 0; n < x.size(); n++) {
        if (uses[n] != row_use::none) {
            const double angle = two_pi * periods * static_cast<double>(n);
            const double c = std::cos(angle);
            const double s = std::sin(angle);
            cc += c * c;
            cs += c * s;
            ss += s * s;
            xc += x[n] * c;
            xs += x[n] * s;
        }
    }
    const double determinant = cc * ss - cs * cs;
    if (!(determinant > 0.0)) {
        return {};
    }
    const double cosine = (ss * xc - cs * xs) / determinant;
    const double sine = (cc * xs - cs * xc) / determinant;
    return {cosine, sine, cosine * xc + sine * xs, periods};
}

} // namespace

void remove_lines(std::vector<double> &error, const std::vector<row_use> &uses)
{
    constexpr int lines_max = 3;
    constexpr int halvings = 9;
    for (int line = 0; line < lines_max; line++) {
        const double periods = standing_line_periods(error);
        if (periods == 0.0) {
            return;
        }
        wave best = fit_wave(error, uses, periods);
        double step = 0.5 / static_cast<double>(power_of_two_below(error.size()));
        for (int i = 0; i < halvings; i++) {
            for (const double tried : {best.periods - step, best.periods + step}) {
                const wave other = fit_wave(error, uses, tried);
                best = other.square > best.square ? other : best;
            }
            step *= 0.5;
        }
        for (std::size_t n = 0; n < error.size(); n++) {
            const double angle = two_pi * best.periods * static_cast<double>(n);
            error[n] -= uses[n] == row_use::none ? 0.0 : best.cosine * std::cos(angle) + best.sine * std::sin(angle);
        }
    }
}

std::vector<double> strongest_pitches_m(const std::vector<double> &error, const std::vector<double> &position_m,
                                        int count)
{
    const auto [least, largest] = std::minmax_element(position_m.begin(), position_m.end());
    const double span_m = *largest - *least;
    if (!(span_m > 0.0)) {
        return {};
    }
    /* The error averaged over bins of position, then its lines. */
    constexpr std::size_t bins = 1024;
    std::vector<double> sums(bins, 0.0);
    std::vector<double> rows(bins, 0.0);
    for (std::size_t n = 0; n < error.size(); n++) {
        const auto bin = std::min(bins - 1, static_cast<std::size_t>((position_m[n] - *least) / span_m * bins));
        sums[bin] += error[n];
        rows[bin] += 1.0;
    }
    std::vector<double> padded(4 * bins, 0.0);
    for (std::size_t i = 0; i < bins; i++) {
        /* By the square root of the rows: bins with few of them are noisy. */
        padded[i] = rows[i] > 0.0 ? sums[i] / std::sqrt(rows[i]) : 0.0;
    }
    const std::vector<std::complex<double>> lines = spectrum_of(padded);
    std::vector<double> pitches;
    std::vector<bool> taken(padded.size() / 2, false);
    while (static_cast<int>(pitches.size()) < count) {
        std::size_t best = 0;
        for (std::size_t i = 6; i < padded.size() / 4; i++) {
            if (!taken[i] && (best == 0 || std::norm(lines[i]) > std::norm(lines[best]))) {
                best = i;
            }
        }
        if (best == 0) {
            break;
        }
        for (std::size_t i = best - 4; i <= best + 4; i++) {
            taken[i] = true;
        }
        pitches.push_back(4.0 * span_m / static_cast<double>(best));
    }
    return pitches;
}

} // namespace berth
