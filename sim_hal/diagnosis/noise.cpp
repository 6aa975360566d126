#include "noise.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>
#include <limits>

namespace berth
{

namespace
{

/* Sums of products e_(n-i) e_(n-j) over rows of which all lags are in use. */
Eigen::MatrixXd lag_products(const std::vector<double> &error, const std::vector<row_use> &uses, int lags,
                             std::size_t &rows)
{
    Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(lags + 1, lags + 1);
    int run = 0;
    rows = 0;
    for (std::size_t n = 0; n < error.size(); n++) {
        run = uses[n] == row_use::none ? 0 : run + 1;
        if (run <= lags) {
            continue;
        }
        rows++;
        for (int i = 0; i <= lags; i++) {
            for (int j = 0; j <= i; j++) {
                sums(i, j) += error[n - static_cast<std::size_t>(i)] * error[n - static_cast<std::size_t>(j)];
            }
        }
    }
    sums.triangularView<Eigen::Upper>() = sums.transpose();
    return sums;
}

} // namespace

noise_model estimate_noise(const std::vector<double> &error, const std::vector<row_use> &uses, int order_max)
{
    std::size_t rows = 0;
    const Eigen::MatrixXd sums = lag_products(error, uses, order_max, rows);
    noise_model best;
    if (rows < 20 || !(sums(0, 0) > 0.0)) {
        best.sigma = best.rms =
            std::max(1e-300, std::sqrt(sums(0, 0) / std::max<double>(1.0, static_cast<double>(rows))));
        return best;
    }
    best.rows = rows;
    const double count = static_cast<double>(rows);
    double best_bic = 0.0;
    for (int order = 0; order <= order_max; order++) {
        Eigen::VectorXd a(order);
        double left = sums(0, 0);
        if (order > 0) {
            Eigen::MatrixXd g = sums.block(1, 1, order, order);
            g.diagonal().array() *= 1.0 + 1e-12;
            a = g.ldlt().solve(sums.col(0).segment(1, order));
            left -= a.dot(sums.col(0).segment(1, order));
        }
        left = std::max(left, 1e-14 * sums(0, 0));
        const double bic = count * std::log(left / count) + order * std::log(count);
        if (order == 0 || bic < best_bic - 6.0) {
            best_bic = bic;
            best.ar.assign(a.data(), a.data() + order);
            best.sigma = std::sqrt(left / count);
        }
    }
    best.rms = std::sqrt(sums(0, 0) / count);
    return best;
}

double median_of(std::vector<double> values)
{
    if (values.empty()) {
        return 0.0;
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

noise_model estimate_noise_robustly(const std::vector<double> &error, const std::vector<row_use> &uses)
{
    constexpr double far = 4.5; /* standard deviations: of normal noise one row in 150000 */
    constexpr std::size_t margin = 8;
    std::vector<row_use> usual = uses;
    noise_model noise = estimate_noise(error, usual);
    for (int pass = 0; pass < 3; pass++) {
        std::vector<double> white;
        std::vector<double> sizes;
        std::vector<row_use> all(uses);
        for (row_use &use : all) {
            use = use == row_use::none ? row_use::none : row_use::fit;
        }
        whiten(noise, error, all, row_use::fit, white);
        sizes.reserve(white.size());
        for (const double value : white) {
            sizes.push_back(std::abs(value));
        }
        const double sigma = 1.4826 * median_of(sizes);
        if (!(sigma > 0.0) || sigma > 0.9) {
            break; /* no tails to speak of */
        }
        usual = uses;
        std::size_t run = 0;
        std::size_t at = 0;
        std::size_t kept = 0;
        for (std::size_t n = 0; n < error.size(); n++) {
            run = uses[n] == row_use::none ? 0 : run + 1;
            if (run > noise.ar.size() && sizes[at++] > far * sigma) {
                const std::size_t end = std::min(error.size(), n + margin);
                for (std::size_t k = n < margin ? 0 : n - margin; k < end; k++) {
                    usual[k] = row_use::none;
                }
            }
        }
        for (const row_use use : usual) {
            kept += use != row_use::none;
        }
        if (3 * kept < error.size()) {
            break; /* what is unusual is the rule */
        }
        noise = estimate_noise(error, usual);
    }
    return noise;
}

void whiten(const noise_model &noise, const std::vector<double> &error, const std::vector<row_use> &uses,
            row_use use, std::vector<double> &white)
{
    white.clear();
    const std::size_t order = noise.ar.size();
    const double scale = 1.0 / noise.sigma;
    std::size_t run = 0;
    for (std::size_t n = 0; n < error.size(); n++) {
        run = uses[n] == row_use::none ? 0 : run + 1;
        if (uses[n] != use || run <= order) {
            continue;
        }
        double value = error[n];
        for (std::size_t i = 0; i < order; i++) {
            value -= noise.ar[i] * error[n - 1 - i];
        }
        white.push_back(scale * value);
    }
}

noise_model at_least(const noise_model &noise, double rms)
{
    return noise.rms < rms ? noise_model{{}, rms, rms, 1.0, noise.rows} : noise;
}

double sum_of_squares(const std::vector<double> &values)
{
    double sum = 0.0;
    for (const double value : values) {
        sum += value * value;
    }
    return sum;
}

double rms_of(const std::vector<double> &error, const std::vector<row_use> &uses, row_use use)
{
    double sum = 0.0;
    std::size_t count = 0;
    for (std::size_t n = 0; n < error.size(); n++) {
        if (uses[n] == use) {
            sum += error[n] * error[n];
            count++;
        }
    }
    return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0;
}

double lattice_step(const std::vector<double> &values)
{
    double step = std::numeric_limits<double>::infinity();
    for (std::size_t n = 1; n < values.size(); n++) {
        const double change = std::abs(values[n] - values[n - 1]);
        if (change > 0.0) {
            step = std::min(step, change);
        }
    }
    std::size_t odd = 0;
    for (std::size_t n = 1; n < values.size(); n++) {
        const double steps = std::abs(values[n] - values[n - 1]) / step;
        odd += std::abs(steps - std::round(steps)) > 0.01 + 1e-4 * steps;
    }
    return step < std::numeric_limits<double>::infinity() && odd * 100 <= values.size() ? step : 0.0;
}

} // namespace berth
