#include "spectrum_lines.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

namespace berth
{

double strongest_frequency_Hz(const std::vector<double> &error, double period_s)
{
    std::size_t size = 1;
    while (size * 2 <= error.size()) {
        size *= 2;
    }
    size *= 2; /* padded: a finer grid than the record's own */
    std::vector<double> padded(error);
    padded.resize(std::max(size, error.size()), 0.0);
    padded.resize(size);
    double mean = 0.0;
    const std::size_t used = std::min(size, error.size());
    for (std::size_t n = 0; n < used; n++) {
        mean += error[n] / static_cast<double>(used);
    }
    for (std::size_t n = 0; n < used; n++) {
        padded[n] -= mean;
    }
    Eigen::FFT<double> fft;
    std::vector<std::complex<double>> lines;
    fft.fwd(lines, padded);
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
