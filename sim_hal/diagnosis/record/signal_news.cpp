#include "signal_news.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>

#include "../../solver/factors.h"
#include "../noise/noise.h"

namespace berth
{

namespace
{

/* Rows of the signal's own past and of its cause's that say what is no news; behind 20 ms at 1 kHz a dead time of a
 * robot is over. */
constexpr std::size_t own_rows = 8;
constexpr std::size_t cause_rows = 24;

/* Changes, so that what stands still has no news. */
Eigen::MatrixXd past_of(const measured_signal &signal, const std::vector<std::size_t> &rows)
{
    const std::size_t causes = signal.cause.empty() ? 0 : cause_rows;
    Eigen::MatrixXd past(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(own_rows + causes));
    for (std::size_t i = 0; i < rows.size(); i++) {
        for (std::size_t k = 1; k <= own_rows + causes; k++) {
            past(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k - 1)) =
                k <= own_rows ? change(signal.values, rows[i] - k) : change(signal.cause, rows[i] - (k - own_rows));
        }
    }
    return past;
}

/* How the past tells the change in a row, by least squares over some thousands of rows in even distance. */
Eigen::VectorXd prediction_of(const measured_signal &signal)
{
    constexpr std::size_t rows_most = 4000;
    const std::size_t every = 1 + signal.values.size() / rows_most;
    std::vector<std::size_t> rows;
    for (std::size_t n = cause_rows + 1; n < signal.values.size(); n += every) {
        rows.push_back(n);
    }
    const Eigen::MatrixXd past = past_of(signal, rows);
    Eigen::VectorXd changes(past.rows());
    for (std::size_t i = 0; i < rows.size(); i++) {
        changes(static_cast<Eigen::Index>(i)) = change(signal.values, rows[i]);
    }
    const Eigen::VectorXd scale =
        past.colwise().norm().transpose().unaryExpr([](double size) { return size > 0.0 ? 1.0 / size : 0.0; });
    const Eigen::MatrixXd scaled = past * scale.asDiagonal();
    Eigen::MatrixXd normal = scaled.transpose() * scaled;
    normal.diagonal().array() += 1e-12;
    return scale.cwiseProduct(semidefinite_solution(normal, scaled.transpose() * changes));
}

/* Gain from white noise in the signal to its news. */
double gain_of(const Eigen::VectorXd &prediction)
{
    std::vector<double> weights = {1.0};
    for (std::size_t k = 0; k < own_rows; k++) {
        weights.push_back(-prediction(static_cast<Eigen::Index>(k)));
    }
    weights.push_back(0.0);
    double square = 1.0;
    for (std::size_t k = 1; k < weights.size(); k++) {
        square += std::pow(weights[k] - weights[k - 1], 2);
    }
    return std::sqrt(square);
}

} // namespace

measured_signal measured_signal::backwards() const
{
    return {
        {values.rbegin(), values.rend()}, {cause.rbegin(), cause.rend()}, {is_guessed.rbegin(), is_guessed.rend()}};
}

double change(const std::vector<double> &x, std::size_t row)
{
    return x[row] - x[row - 1];
}

signal_news news_of(const measured_signal &signal)
{
    constexpr double rms_of_median = 1.4826; /* of the sizes of a normal noise */
    const std::size_t size = signal.values.size();
    signal_news made;
    made.signs.assign(size, 0.0);
    made.news.assign(size, 0.0);
    const Eigen::VectorXd prediction = prediction_of(signal);
    const std::size_t past_rows = static_cast<std::size_t>(prediction.size()) > own_rows ? cause_rows : own_rows;
    std::size_t last_guessed = 0;
    std::vector<double> sizes;
    for (std::size_t n = past_rows + 1; n < size; n++) {
        if (!signal.is_guessed.empty() && signal.is_guessed[n] != 0) {
            last_guessed = n;
        }
        if (n <= last_guessed + own_rows) {
            continue;
        }
        double told = 0.0;
        for (std::size_t k = 1; k <= static_cast<std::size_t>(prediction.size()); k++) {
            told += prediction(static_cast<Eigen::Index>(k - 1)) *
                    (k <= own_rows ? change(signal.values, n - k) : change(signal.cause, n - (k - own_rows)));
        }
        made.news[n] = change(signal.values, n) - told;
        made.signs[n] = static_cast<double>(made.news[n] > 0.0) - static_cast<double>(made.news[n] < 0.0);
        sizes.push_back(std::abs(made.news[n]));
    }
    made.noise_rms = sizes.empty() ? 0.0 : rms_of_median * median_of(std::move(sizes)) / gain_of(prediction);
    return made;
}

} // namespace berth
