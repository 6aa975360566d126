#include "leftover.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <Eigen/Core>
#include <functional>

#include "../../solver/factors.h"

namespace berth
{

namespace
{

/* Each is predicted from all others. */
constexpr std::size_t blocks = 12;

struct normal_equations {
    Eigen::MatrixXd g;
    Eigen::VectorXd b;
    double square = 0.0;
    double rows = 0.0;
};

/* `ridge`: of the diagonal. Features may depend on each other, or be small against the noise. */
Eigen::VectorXd solve(const Eigen::MatrixXd &g, const Eigen::VectorXd &b, double ridge)
{
    Eigen::MatrixXd regular = g;
    regular.diagonal() *= 1.0 + ridge;
    regular.diagonal().array() += 1e-6;
    return semidefinite_solution(regular, b);
}

using block_parts = std::array<normal_equations, blocks>;

/* In four sums, which a compiler can add up two at a time; Eigen does not, see the Makefile. */
double product(const double *a, const double *b, std::size_t count)
{
    constexpr std::size_t lanes = 4;
    std::array<double, lanes> sums{};
    std::size_t n = 0;
    for (; n + lanes <= count; n += lanes) {
        for (std::size_t lane = 0; lane < lanes; lane++) {
            sums[lane] += a[n + lane] * b[n + lane];
        }
    }
    double rest = 0.0;
    for (; n < count; n++) {
        rest += a[n] * b[n];
    }
    return sums[0] + sums[1] + sums[2] + sums[3] + rest;
}

/* Rows out of use are 0 in white, and say nothing. */
block_parts equations_of(const std::vector<feature> &features, const std::vector<double> &error,
                         const whitening &by_row)
{
    const std::size_t size = error.size();
    Eigen::MatrixXd white(static_cast<Eigen::Index>(size), static_cast<Eigen::Index>(features.size()));
    Eigen::VectorXd target(static_cast<Eigen::Index>(size));
    for (std::size_t i = 0; i < features.size(); i++) {
        by_row.apply(features[i].values, white.col(static_cast<Eigen::Index>(i)).data());
    }
    by_row.apply(error, target.data());
    block_parts parts;
    for (std::size_t i = 0; i < blocks; i++) {
        const std::size_t begin = (i * size + blocks - 1) / blocks;
        const std::size_t end = ((i + 1) * size + blocks - 1) / blocks;
        const auto first = static_cast<Eigen::Index>(begin);
        const auto count = static_cast<Eigen::Index>(end - begin);
        const auto rows = white.middleRows(first, count);
        normal_equations &part = parts[i];
        part.g.resize(white.cols(), white.cols());
        part.b.resize(white.cols());
        for (Eigen::Index column = 0; column < white.cols(); column++) {
            const double *const by = rows.col(column).data();
            for (Eigen::Index row = 0; row <= column; row++) {
                part.g(row, column) = product(rows.col(row).data(), by, end - begin);
                part.g(column, row) = part.g(row, column);
            }
            part.b(column) = product(target.data() + begin, by, end - begin);
        }
        part.square = target.segment(first, count).squaredNorm();
        for (std::size_t n = begin; n < end; n++) {
            part.rows += by_row.is_known(n) ? 1.0 : 0.0;
        }
    }
    return parts;
}

normal_equations sum_of(const block_parts &parts)
{
    normal_equations all = parts[0];
    for (std::size_t i = 1; i < blocks; i++) {
        all.g += parts[i].g;
        all.b += parts[i].b;
        all.square += parts[i].square;
        all.rows += parts[i].rows;
    }
    return all;
}

struct prediction {
    double explained = -unlimited; /* sum of squares, of blocks by what the others say */
    double ridge = 0.0;
};

/* With the ridge that predicts best. */
prediction predict_across(const block_parts &parts)
{
    const normal_equations all = sum_of(parts);
    prediction best;
    for (const double ridge : {1e-7, 1e-5, 1e-3, 0.1, 10.0, 1e3}) {
        double explained = 0.0;
        for (const normal_equations &unseen : parts) {
            const Eigen::VectorXd c = solve(all.g - unseen.g, all.b - unseen.b, ridge);
            explained += 2.0 * c.dot(unseen.b) - c.dot(unseen.g * c);
        }
        if (explained > best.explained) {
            best = {explained, ridge};
        }
    }
    return best;
}

using feature_choice = std::function<bool(const feature &)>;

/* The equations of some of the features alone. */
block_parts of_those(const block_parts &parts, const std::vector<feature> &features, const feature_choice &is_chosen)
{
    std::vector<Eigen::Index> chosen;
    for (std::size_t i = 0; i < features.size(); i++) {
        if (is_chosen(features[i])) {
            chosen.push_back(static_cast<Eigen::Index>(i));
        }
    }
    block_parts made;
    for (std::size_t i = 0; i < blocks; i++) {
        made[i] = {parts[i].g(chosen, chosen), parts[i].b(chosen), parts[i].square, parts[i].rows};
    }
    return made;
}

/* The class that predicts most by itself and a constant, which goes with each: where features resemble each other,
 * their shares in a sum say little. */
error_class strongest_class(const block_parts &parts, const std::vector<feature> &features)
{
    constexpr double clearly = 1.01; /* a constant alone is even */
    constexpr error_class even_first[] = {error_class::even, error_class::linear, error_class::odd,
                                          error_class::drift, error_class::hysteresis};
    error_class strongest = error_class::even;
    double most = 0.0;
    for (const error_class of : even_first) {
        const auto is_of_class = [&](const feature &one) { return one.kind == of || one.is_constant; };
        const double explained = predict_across(of_those(parts, features, is_of_class)).explained;
        if (explained > clearly * most) {
            most = explained;
            strongest = of;
        }
    }
    return strongest;
}

} // namespace

std::vector<double> unexplained_by(const block_model &model, const noise_model &noise,
                                   const std::vector<feature> &features, const std::vector<double> &error)
{
    const std::vector<row_use> &uses = model.uses();
    const block_parts parts = equations_of(features, error, whitening(noise, uses));
    const normal_equations all = sum_of(parts);
    const Eigen::VectorXd c = solve(all.g, all.b, predict_across(parts).ridge);
    std::vector<double> unexplained = error;
    for (std::size_t i = 0; i < features.size(); i++) {
        const double share = c(static_cast<Eigen::Index>(i));
        for (std::size_t n = 0; n < error.size(); n++) {
            unexplained[n] -= uses[n] != row_use::none ? share * features[i].values[n] : 0.0;
        }
    }
    return unexplained;
}

leftover find_leftover(const block_model &model, const noise_model &noise, const rig &rig,
                       const std::vector<double> &error)
{
    const std::vector<feature> features = features_of_motion(model, rig, error);
    const block_parts parts = equations_of(features, error, whitening(noise, model.uses()));
    const normal_equations all = sum_of(parts);
    /* Few, they predict what they explain well beside many that explain nothing. */
    const auto is_of_shape = [](const feature &one) { return one.is_of_shape; };
    leftover result;
    result.explained =
        std::max(predict_across(parts).explained, predict_across(of_those(parts, features, is_of_shape)).explained);
    result.rows = all.rows / noise.rows_per_fact;
    result.share_of_rms = result.explained / std::max(1e-300, all.square);
    result.strongest = strongest_class(parts, features);
    return result;
}

} // namespace berth
