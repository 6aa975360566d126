#include "response.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <iterator>
#include <utility>

#include "../../solver/decompositions.h"
#include "../../solver/factors.h"

namespace berth
{

Eigen::VectorXd white_error(block_model &model, const noise_model &noise, const rig &rig)
{
    std::vector<double> error;
    std::vector<double> white;
    model.error(rig, error);
    whiten(noise, error, model.uses(), row_use::fit, white);
    return Eigen::Map<const Eigen::VectorXd>(white.data(), static_cast<Eigen::Index>(white.size()));
}

rig with_values(const rig &base, const effect &effect, const effect_values &values)
{
    rig made = base;
    if (effect.switch_on != nullptr) {
        effect.switch_on(made);
    }
    for (std::size_t i = 0; i < values.size(); i++) {
        set_number(made, effect.parameters[i].key, values[i]);
    }
    return made;
}

known_slopes slopes_at(block_model &model, const noise_model &noise, const fit_result &at,
                       const Eigen::VectorXd &white)
{
    known_slopes made;
    made.white = Eigen::MatrixXd::Zero(white.size(), static_cast<Eigen::Index>(at.parameters.size()));
    const double change_max = change_max_per_row * std::sqrt(static_cast<double>(white.size()));
    for (const free_parameter &parameter : at.parameters) {
        rig moved = at.rig;
        double &value = *static_cast<double *>(parameter.key->member(moved));
        const double there = value;
        const double inward = there > 0.5 * (parameter.low + parameter.high) ? -1.0 : 1.0;
        double step = inward * 1e-4 * (there != 0.0 ? std::abs(there) : parameter.high - parameter.low);
        value = there + step;
        Eigen::VectorXd change = white_error(model, noise, moved) - white;
        if (const double size = change.norm(); size > change_max) {
            step *= 0.3 * change_max / size;
            value = there + step;
            change = white_error(model, noise, moved) - white;
        }
        made.white.col(static_cast<Eigen::Index>(made.keys.size())) = change / step;
        made.keys.push_back(parameter.key);
    }
    return made;
}

namespace
{

/* Of what the basis leaves of an error, with `change` added to that. */
tangent_space::prospect best_of(const Eigen::MatrixXd &basis, const Eigen::VectorXd &rest,
                                const Eigen::VectorXd &change, double least, double most)
{
    constexpr double cancels = 1e-8; /* of the square; what is less has lost its digits */
    const Eigen::VectorXd made_up = basis.transpose() * change;
    const double change_square = change.squaredNorm();
    double square = change_square - made_up.squaredNorm();
    double along = change.dot(rest); /* nothing of the rest lies in the basis */
    if (square < cancels * change_square) {
        const Eigen::VectorXd left = change - basis * made_up;
        square = left.squaredNorm();
        along = left.dot(rest);
    }
    if (!(square > 0.0) || !std::isfinite(square)) {
        return {0.0, least};
    }
    const double share = std::min(most, std::max(least, -along / square));
    return {-share * (2.0 * along + share * square), share};
}

} // namespace

tangent_space::tangent_space(const fit_result &at, const known_slopes &slopes)
{
    basis_ = Eigen::MatrixXd::Zero(slopes.white.rows(), 0);
    if (at.parameters.empty()) {
        return;
    }
    keys_ = slopes.keys;
    slopes_of_all_ = slopes.white;
    sizes_ = slopes.white.colwise().norm();
    Eigen::MatrixXd free = slopes.white;
    bool any_at_bound = false;
    for (Eigen::Index i = 0; i < free.cols(); i++) {
        const free_parameter &parameter = at.parameters[static_cast<std::size_t>(i)];
        const double value = value_of(at.rig, parameter.key->path);
        const double place = (value - parameter.low) / (parameter.high - parameter.low);
        inward_.push_back(place < 0.01 ? 1.0 : place > 0.99 ? -1.0 : 0.0);
        any_at_bound = any_at_bound || inward_.back() != 0.0;
        slopes_of_all_.col(i) *= sizes_(i) > 0.0 ? 1.0 / sizes_(i) : 0.0;
        free.col(i) = slopes_of_all_.col(i) * (inward_.back() != 0.0 ? 0.0 : 1.0);
    }
    basis_ = column_space(free);
    if (any_at_bound) {
        basis_of_all_ = column_space(slopes_of_all_);
        products_of_all_ = slopes_of_all_.transpose() * slopes_of_all_;
    }
}

tangent_space::target tangent_space::target_of(const Eigen::VectorXd &white) const
{
    target made{white, less(white), {}, 0.0, {}};
    if (basis_of_all_.size() > 0) {
        made.along_all = slopes_of_all_.transpose() * white;
        made.rest_of_all = white - basis_of_all_ * (basis_of_all_.transpose() * white);
        made.decrease_by_all = white.squaredNorm() - made.rest_of_all.squaredNorm();
    }
    return made;
}

bool tangent_space::is_of(const effect *changed, Eigen::Index column) const
{
    const auto is_it = [&](const effect_parameter &parameter) {
        return parameter.key == keys_[static_cast<std::size_t>(column)]->path;
    };
    return changed != nullptr && std::any_of(changed->parameters.begin(), changed->parameters.end(), is_it);
}

tangent_space::prospect tangent_space::best_share(const target &error, const Eigen::VectorXd &change, double least,
                                                  double most, const effect *changed) const
{
    const prospect best = best_of(basis_, error.rest, change, least, most);
    if (basis_of_all_.size() == 0) {
        return best;
    }
    prospect more = best_of(basis_of_all_, error.rest_of_all, change, least, most);
    more.decrease += error.decrease_by_all;
    if (more.decrease <= best.decrease) {
        return best; /* those at a bound would not help if they could go anywhere */
    }
    const Eigen::VectorXd moved = least_squares_solution(slopes_of_all_, -(error.white + more.share * change));
    bool are_all_inward = true;
    std::vector<Eigen::Index> released;
    for (Eigen::Index i = 0; i < moved.size(); i++) {
        const double inward = inward_[static_cast<std::size_t>(i)];
        const bool is_own = inward != 0.0 && is_of(changed, i);
        are_all_inward = are_all_inward && !is_own && inward * moved(i) >= 0.0;
        if (!is_own) {
            released.push_back(i);
        }
    }
    if (!are_all_inward) {
        more = best_inward(error, change, least, most, std::move(released));
    }
    return more.decrease > best.decrease ? more : best;
}

tangent_space::prospect tangent_space::best_inward(const target &error, const Eigen::VectorXd &change, double least,
                                                   double most, std::vector<Eigen::Index> released) const
{
    constexpr double rounding = 1e-12; /* of slopes of size 1 that hang together */
    const Eigen::VectorXd along = slopes_of_all_.transpose() * change;
    const double error_square = error.white.squaredNorm();
    const double change_square = change.squaredNorm();
    const double both = error.white.dot(change);
    for (;;) {
        Eigen::MatrixXd products = products_of_all_(released, released);
        products.diagonal().array() += rounding;
        const Eigen::VectorXd for_error = positive_solution(products, error.along_all(released));
        const Eigen::VectorXd for_change = positive_solution(products, along(released));
        const double square = change_square - along(released).dot(for_change);
        if (!(square > 0.0) || !std::isfinite(square)) {
            return {0.0, least};
        }
        const double rest = error_square - error.along_all(released).dot(for_error);
        const double rest_along = both - error.along_all(released).dot(for_change);
        const double share = std::min(most, std::max(least, -rest_along / square));
        const auto goes_out = [&](Eigen::Index column) {
            const auto place = std::find(released.begin(), released.end(), column) - released.begin();
            const double moved = -(for_error(place) + share * for_change(place));
            return inward_[static_cast<std::size_t>(column)] * moved < 0.0;
        };
        std::vector<Eigen::Index> kept;
        std::copy_if(released.begin(), released.end(), std::back_inserter(kept),
                     [&](Eigen::Index column) { return !goes_out(column); });
        if (kept.size() == released.size()) {
            return {error_square - (rest + share * (2.0 * rest_along + share * square)), share};
        }
        released = std::move(kept);
    }
}

std::optional<effect_values> tangent_space::beyond_bounds(const fit_result &at, const target &error,
                                                          const effect &own) const
{
    bool is_held = false;
    for (std::size_t i = 0; i < inward_.size(); i++) {
        is_held = is_held || (inward_[i] != 0.0 && is_of(&own, static_cast<Eigen::Index>(i)));
    }
    if (!is_held) {
        return std::nullopt;
    }
    const Eigen::VectorXd moved = least_norm_solution(slopes_of_all_, -error.white);
    effect_values values;
    for (const effect_parameter &parameter : own.parameters) {
        double value = value_of(at.rig, parameter.key);
        for (std::size_t i = 0; i < keys_.size(); i++) {
            const auto column = static_cast<Eigen::Index>(i);
            if (keys_[i]->path == parameter.key && sizes_(column) > 0.0) {
                value += moved(column) / sizes_(column);
            }
        }
        values.push_back(std::clamp(value, parameter.low, parameter.high));
    }
    return values;
}

double tangent_space::least_left(const target &error, const Eigen::VectorXd &change, double least, double most) const
{
    const bool any_at_bound = basis_of_all_.size() > 0;
    const Eigen::VectorXd &rest = any_at_bound ? error.rest_of_all : error.rest;
    return rest.squaredNorm() - best_of(any_at_bound ? basis_of_all_ : basis_, rest, change, least, most).decrease;
}

} // namespace berth
