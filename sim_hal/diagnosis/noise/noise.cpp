#include "noise.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <limits>

#include "../../solver/factors.h"
#include "lattice_step.h"

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

/* White noise and a slow one, by the prediction error; `best_bic` and `count` are those of the best regression. */
void try_slow_noise(const std::vector<double> &error, const std::vector<row_use> &uses, double count,
                    double best_bic, noise_model &best)
{
    constexpr int parameters = 2;
    noise_model tried;
    tried.rms = best.rms;
    tried.rows = best.rows;
    std::vector<row_use> all = uses;
    std::replace(all.begin(), all.end(), row_use::held_out, row_use::fit);
    std::vector<double> white;
    const auto variance_of = [&](double rows_long, double gain) {
        tried.slow_decay = std::exp(-1.0 / rows_long);
        tried.slow_gain = gain;
        whiten(tried, error, all, row_use::fit, white);
        return sum_of_squares(white) / static_cast<double>(std::max<std::size_t>(1, white.size()));
    };
    double rows_long = 0.0;
    double gain = 0.0;
    double least = std::numeric_limits<double>::infinity();
    const auto look_at = [&](double other_rows_long, double other_gain) {
        const double variance = other_gain < 1.0 ? variance_of(other_rows_long, other_gain) : least;
        if (variance < least) {
            least = variance;
            rows_long = other_rows_long;
            gain = other_gain;
        }
    };
    for (const double length : {3.0, 12.0, 50.0, 200.0, 800.0}) {
        for (const double share : {0.03, 0.1, 0.3, 0.7}) {
            look_at(length, share);
        }
    }
    double factor = 2.0;
    for (int round = 0; round < 3; round++) {
        const double length = rows_long;
        const double share = gain;
        for (const double by : {1.0 / factor, factor}) {
            look_at(length * by, share);
            look_at(length, share * by);
        }
        factor = std::sqrt(factor);
    }
    const double variance = variance_of(rows_long, gain);
    const double bic = count * std::log(std::max(variance, 1e-300)) + parameters * std::log(count);
    if (bic < best_bic - 6.0) {
        best = tried;
        best.sigma = std::sqrt(variance);
    }
}

} // namespace

noise_model estimate_noise(const std::vector<double> &error, const std::vector<row_use> &uses, int order_max,
                           colour colour)
{
    const auto in_use = static_cast<std::size_t>(
        std::count_if(uses.begin(), uses.end(), [](row_use use) { return use != row_use::none; }));
    std::size_t rows = 0;
    Eigen::MatrixXd sums = lag_products(error, uses, order_max, rows);
    while (order_max > 0 && 2 * rows < in_use) { /* where many rows are missing, few have so long a past */
        sums = lag_products(error, uses, --order_max, rows);
    }
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
            a = semidefinite_solution(g, sums.col(0).segment(1, order));
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
    if (!best.ar.empty() && colour == colour::regression_or_slow) {
        try_slow_noise(error, uses, count, best_bic, best);
    }
    return best;
}

noise_model noise_of_differences(const std::vector<double> &error, const std::vector<row_use> &uses)
{
    std::vector<double> sizes;
    for (std::size_t n = 3; n < error.size(); n++) {
        if (std::all_of(uses.begin() + static_cast<std::ptrdiff_t>(n) - 3,
                        uses.begin() + static_cast<std::ptrdiff_t>(n) + 1,
                        [](row_use use) { return use == row_use::fit; })) {
            sizes.push_back(std::abs(error[n] - 3.0 * error[n - 1] + 3.0 * error[n - 2] - error[n - 3]));
        }
    }
    noise_model noise;
    noise.rows = sizes.size();
    noise.sigma = noise.rms = std::max(1e-300, 1.4826 * median_of(sizes) / std::sqrt(20.0));
    return noise;
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

noise_model estimate_noise_robustly(const std::vector<double> &error, const std::vector<row_use> &uses,
                                    colour colour)
{
    constexpr int order_max = 8;
    constexpr double far = 4.5; /* standard deviations: of normal noise one row in 150000 */
    constexpr std::size_t margin = 8;
    std::vector<row_use> usual = uses;
    noise_model noise = estimate_noise(error, usual, order_max, colour);
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
        noise = estimate_noise(error, usual, order_max, colour);
    }
    return noise;
}

whitening::whitening(const noise_model &noise, const std::vector<row_use> &uses)
    : noise_(noise), is_known_(uses.size(), 0)
{
    const std::size_t order = noise.ar.size();
    std::size_t run = 0;
    for (std::size_t n = 0; n < uses.size(); n++) {
        run = uses[n] == row_use::none ? 0 : run + 1;
        is_known_[n] = run > order;
    }
    if (!(noise.slow_gain > 0.0)) {
        return;
    }
    /* Variances, where what is new has 1 in the long run: of the white noise, of what drives the slow one, and of
     * the slow one's prediction, which begins without a past. */
    const double keep = noise.slow_decay * noise.slow_decay;
    const double white = 1.0 - noise.slow_gain;
    const double drive = noise.slow_gain * (1.0 - keep * white);
    double predicted = drive / (1.0 - keep);
    gain_.resize(uses.size());
    scale_.resize(uses.size());
    double of = -1.0; /* the prediction that these are of: in the long run it stays the same */
    double gain = 0.0;
    double scale = 0.0;
    for (std::size_t n = 0; n < uses.size(); n++) {
        if (predicted != of) {
            of = predicted;
            gain = predicted / (predicted + white);
            scale = 1.0 / (noise.sigma * std::sqrt(predicted + white));
        }
        gain_[n] = is_known_[n] != 0 ? gain : 0.0;
        scale_[n] = scale;
        predicted = keep * predicted * (1.0 - gain_[n]) + drive;
    }
}

void whitening::apply(const std::vector<double> &x, double *white) const
{
    double slow = 0.0;
    const std::size_t order = noise_.ar.size();
    const double scale = 1.0 / noise_.sigma;
    for (std::size_t n = 0; n < x.size(); n++) {
        white[n] = 0.0;
        if (!gain_.empty()) {
            const double news = x[n] - slow;
            white[n] = is_known_[n] != 0 ? scale_[n] * news : 0.0;
            slow = noise_.slow_decay * (is_known_[n] != 0 ? slow + gain_[n] * news : slow);
        } else if (is_known_[n] != 0) {
            double value = x[n];
            for (std::size_t i = 0; i < order; i++) {
                value -= noise_.ar[i] * x[n - 1 - i];
            }
            white[n] = scale * value;
        }
    }
}

void whiten(const noise_model &noise, const std::vector<double> &error, const std::vector<row_use> &uses,
            row_use use, std::vector<double> &white)
{
    const whitening by_row(noise, uses);
    std::vector<double> all(error.size());
    by_row.apply(error, all.data());
    white.resize(error.size());
    std::size_t count = 0;
    for (std::size_t n = 0; n < error.size(); n++) {
        white[count] = all[n]; /* stays where the row counts */
        count += uses[n] == use && by_row.is_known(n) ? 1 : 0;
    }
    white.resize(count);
}

namespace
{

/* How many rows in a row say as much as one of white noise; not a number where the regression is unstable, as one of
 * few rows may be. */
double rows_that_hang_together(const noise_model &noise)
{
    constexpr std::size_t lags = 1000;
    std::vector<double> answer(lags, 0.0); /* to one new value */
    answer[0] = 1.0;
    for (std::size_t k = 1; k < lags; k++) {
        for (std::size_t i = 0; i < std::min(k, noise.ar.size()); i++) {
            answer[k] += noise.ar[i] * answer[k - 1 - i];
        }
        if (noise.slow_gain > 0.0) {
            answer[k] = noise.slow_gain * std::pow(noise.slow_decay, static_cast<double>(k));
        }
    }
    double sum = 0.0;
    double variance = 0.0;
    for (std::size_t lag = 0; lag < lags; lag++) {
        double covariance = 0.0;
        for (std::size_t k = lag; k < lags; k++) {
            covariance += answer[k] * answer[k - lag];
        }
        variance = lag == 0 ? covariance : variance;
        sum += (lag == 0 ? 1.0 : 2.0) * std::pow(covariance / variance, 2);
    }
    return noise.rows_per_fact * sum;
}

} // namespace

double rms_ci95(const noise_model &noise, const std::vector<row_use> &uses)
{
    const auto in_use = static_cast<std::size_t>(std::count(uses.begin(), uses.end(), row_use::fit));
    const auto rows = static_cast<double>(std::max<std::size_t>(1, noise.rows > 0 ? noise.rows : in_use));
    const double together = rows_that_hang_together(noise);
    const double facts = together < rows ? rows / together : 1.0;
    return 1.96 * noise.rms * std::sqrt(0.5 / facts);
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

double rows_of_a_reading(const std::vector<double> &values, const std::vector<row_use> &uses)
{
    double squares = 0.0; /* of the lengths */
    double rows = 0.0;
    double length = 0.0;
    for (std::size_t n = 0; n <= values.size(); n++) {
        const bool goes_on = n > 0 && n < values.size() && uses[n] == row_use::fit && values[n] == values[n - 1];
        if (!goes_on) {
            squares += length * length;
            rows += length;
            length = 0.0;
        }
        length += n < values.size() && uses[n] == row_use::fit;
    }
    return squares / std::max(1.0, rows);
}

double rms_of_noise_and_rounding(const std::vector<double> &signal)
{
    const std::vector<row_use> all(signal.size(), row_use::fit);
    return std::max(noise_of_differences(signal, all).rms, lattice_step(signal) / std::sqrt(12.0));
}

} // namespace berth
