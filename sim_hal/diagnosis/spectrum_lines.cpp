#include "spectrum_lines.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

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
    Eigen::FFT<double> fft;
    std::vector<std::complex<double>> lines;
    fft.fwd(lines, padded);
    return lines;
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

bool has_line(const std::vector<double> &error)
{
    constexpr double stands_out = 60.0; /* times the median power about it: noise does once in 1e18 lines */
    constexpr std::size_t about = 40;   /* lines on either side */
    constexpr std::size_t periods_min = 5;
    const std::size_t size = power_of_two_below(error.size());
    if (size < 8 * about) {
        return false;
    }
    const auto lines = lines_of(error, size);
    std::vector<double> power(size / 2);
    for (std::size_t i = 0; i < power.size(); i++) {
        power[i] = std::norm(lines[i]);
    }
    for (std::size_t i = periods_min; i < power.size(); i++) {
        const auto begin = power.begin() + static_cast<std::ptrdiff_t>(i > about ? i - about : 0);
        const auto end = power.begin() + static_cast<std::ptrdiff_t>(std::min(power.size(), i + about + 1));
        if (power[i] > *std::max_element(begin, end) * 0.999 &&
            power[i] > stands_out * median_of(std::vector<double>(begin, end))) {
            return true;
        }
    }
    return false;
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
    Eigen::FFT<double> fft;
    std::vector<std::complex<double>> lines;
    fft.fwd(lines, padded);
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
