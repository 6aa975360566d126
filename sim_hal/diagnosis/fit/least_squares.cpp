#include "least_squares.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Core>
#include <limits>

#include "../../solver/factors.h"

namespace berth
{

namespace
{

enum class place : char { free, at_low, at_high };

/* Minimum over the free variables, the others at their bounds. */
Eigen::VectorXd minimum_of_free(const Eigen::MatrixXd &hessian, const Eigen::VectorXd &gradient,
                                const Eigen::VectorXd &step, const std::vector<place> &places)
{
    std::vector<Eigen::Index> free;
    for (Eigen::Index i = 0; i < step.size(); i++) {
        if (places[static_cast<std::size_t>(i)] == place::free) {
            free.push_back(i);
        }
    }
    const auto count = static_cast<Eigen::Index>(free.size());
    Eigen::MatrixXd h(count, count);
    Eigen::VectorXd g(count);
    for (Eigen::Index i = 0; i < count; i++) {
        const Eigen::Index row = free[static_cast<std::size_t>(i)];
        g(i) = gradient(row);
        for (Eigen::Index j = 0; j < step.size(); j++) {
            if (places[static_cast<std::size_t>(j)] != place::free) {
                g(i) += hessian(row, j) * step(j);
            }
        }
        for (Eigen::Index j = 0; j < count; j++) {
            h(i, j) = hessian(row, free[static_cast<std::size_t>(j)]);
        }
    }
    const Eigen::VectorXd part = semidefinite_solution(h, -g);
    Eigen::VectorXd made = step;
    for (Eigen::Index i = 0; i < count; i++) {
        made(free[static_cast<std::size_t>(i)]) = part(i);
    }
    return made;
}

class marquardt
{
  public:
    marquardt(const least_squares_problem &problem, const Eigen::VectorXd &start)
        : problem_(problem), step_(problem.step)
    {
        now_.x = start.cwiseMax(problem.low).cwiseMin(problem.high);
        evaluate(now_.x, now_.residual);
        now_.sum = now_.residual.squaredNorm();
        now_.jacobian = Eigen::MatrixXd::Zero(now_.residual.size(), start.size());
        for (Eigen::Index i = 0; i < start.size(); i++) {
            if (is_known(i)) {
                now_.jacobian.col(i) = problem.slopes.col(i);
            } else {
                renew_column(i);
            }
        }
        is_fresh_ = problem.slope_is_known.empty();
    }

    least_squares_result run()
    {
        while (now_.evaluations < problem_.evaluations_max) {
            if (iterate()) {
                continue;
            }
            if (is_fresh_ || (problem_.is_first_look && !is_stuck_)) {
                break;
            }
            renew_all();
            is_stuck_ = false;
        }
        if (!is_fresh_ && !problem_.is_first_look) {
            renew_all(); /* what intervals are computed from */
        }
        return std::move(now_);
    }

  private:
    static constexpr double damping_least = 1e-7;
    static constexpr int refusals_bearable = 3; /* of a Jacobian that is not fresh */

    bool is_known(Eigen::Index column) const
    {
        return !problem_.slope_is_known.empty() && problem_.slope_is_known[static_cast<std::size_t>(column)];
    }

    void evaluate(const Eigen::VectorXd &x, Eigen::VectorXd &residual)
    {
        problem_.residual(x, residual);
        evaluated_ = x;
        now_.evaluations++;
    }

    /* At a finite difference from where it is now. */
    void evaluate_beside(const Eigen::VectorXd &x, Eigen::VectorXd &residual)
    {
        if (!problem_.residual_beside) {
            evaluate(x, residual);
            return;
        }
        if (evaluated_ != now_.x) {
            evaluate(now_.x, residual);
        }
        problem_.residual_beside(x, residual);
        now_.evaluations++;
    }

    /* Far from the minimum a difference as small as the noise sees the corners of the error, a reversal in the
     * sub-step before or after, rather than its slope: it moves the residual by a share of what that is. */
    void renew_column(Eigen::Index i)
    {
        constexpr double share = 0.05; /* of the residual; 0.03 and 0.3 lead as far */
        constexpr double widest = 0.05;
        const double most = std::max(problem_.change_max, share * now_.residual.norm());
        const double change = difference(i);
        const bool is_narrow = most > problem_.change_max && change > 0.0 && change < 0.1 * most;
        if ((change > most || is_narrow) && std::isfinite(change)) {
            step_(i) = std::min(std::max(step_(i), widest * (problem_.high(i) - problem_.low(i))),
                                step_(i) * 0.3 * most / change);
            difference(i);
        }
    }

    /* The column by a finite difference; how far that moved the residual. */
    double difference(Eigen::Index i)
    {
        const bool is_in_upper_half = now_.x(i) > 0.5 * (problem_.low(i) + problem_.high(i));
        Eigen::VectorXd moved = now_.x;
        moved(i) += is_in_upper_half ? -step_(i) : step_(i);
        evaluate_beside(moved, tried_);
        now_.jacobian.col(i) = (tried_ - now_.residual) / (moved(i) - now_.x(i));
        return (tried_ - now_.residual).norm();
    }

    void renew_all()
    {
        for (Eigen::Index i = 0; i < now_.x.size(); i++) {
            renew_column(i);
        }
        is_fresh_ = true;
    }

    /* What nobody knew at the start is what bends most. */
    void renew_unknown()
    {
        for (Eigen::Index i = 0; i < now_.x.size(); i++) {
            if (!is_known(i)) {
                renew_column(i);
            }
        }
        is_renewed_ = true;
        is_fresh_ = problem_.slope_is_known.empty();
    }

    /* One step; false: this Jacobian promises nothing worthwhile any more. */
    bool iterate()
    {
        const Eigen::MatrixXd hessian = now_.jacobian.transpose() * now_.jacobian;
        const Eigen::VectorXd gradient = now_.jacobian.transpose() * now_.residual;
        const double worthwhile = problem_.tolerance * now_.sum;
        double harder = 4.0; /* grows: Nielsen's rule */
        for (int refusals = 0; now_.evaluations < problem_.evaluations_max; refusals++) {
            if (refusals > 0) {
                damping_ *= harder;
                harder *= 2.0;
            }
            Eigen::MatrixXd damped = hessian;
            for (Eigen::Index i = 0; i < damped.rows(); i++) {
                damped(i, i) += damping_ * hessian(i, i) + 1e-12;
            }
            const Eigen::VectorXd step =
                bounded_step(damped, gradient, problem_.low - now_.x, problem_.high - now_.x);
            const double promised = -2.0 * gradient.dot(step) - step.dot(hessian * step);
            if (!(promised > worthwhile)) {
                return false;
            }
            evaluate(now_.x + step, tried_);
            const double sum = tried_.squaredNorm();
            const double ratio = (now_.sum - sum) / promised;
            if (std::isfinite(sum) && sum < now_.sum) {
                accept(step, sum, ratio);
                return true;
            }
            if (!is_fresh_ && !is_renewed_) {
                renew_unknown();
                return true;
            }
            if (refusals + 1 >= refusals_bearable && !is_fresh_) {
                is_stuck_ = true;
                return false;
            }
        }
        return false;
    }

    void accept(const Eigen::VectorXd &step, double sum, double ratio)
    {
        const Eigen::VectorXd surprise = tried_ - now_.residual - now_.jacobian * step;
        now_.jacobian += surprise * (step / step.squaredNorm()).transpose();
        now_.x += step;
        now_.residual = tried_;
        now_.sum = sum;
        is_fresh_ = false;
        is_renewed_ = false;
        damping_ = ratio > 0.75 ? std::max(damping_least, 0.1 * damping_) : ratio < 0.25 ? 4.0 * damping_ : damping_;
        if (ratio < 0.5) {
            renew_unknown();
        }
    }

    const least_squares_problem &problem_;
    Eigen::VectorXd step_; /* of finite differences */
    least_squares_result now_;
    Eigen::VectorXd evaluated_; /* last */
    Eigen::VectorXd tried_;
    double damping_ = 1e-3;
    bool is_fresh_ = true;
    bool is_stuck_ = false;  /* the Jacobian is too wrong to go on with */
    bool is_renewed_ = true; /* those columns that were not known at the start */
};

} // namespace

least_squares_result solve_least_squares(const least_squares_problem &problem, const Eigen::VectorXd &start)
{
    return marquardt(problem, start).run();
}

Eigen::VectorXd bounded_step(const Eigen::MatrixXd &hessian, const Eigen::VectorXd &gradient,
                             const Eigen::VectorXd &low, const Eigen::VectorXd &high)
{
    const auto size = static_cast<std::size_t>(gradient.size());
    std::vector<place> places(size, place::free);
    Eigen::VectorXd step = Eigen::VectorXd::Zero(gradient.size());
    for (std::size_t round = 0; round < 4 * size + 4; round++) {
        step = minimum_of_free(hessian, gradient, step, places);
        bool has_changed = false;
        for (std::size_t k = 0; k < size; k++) {
            const auto i = static_cast<Eigen::Index>(k);
            if (places[k] == place::free && (step(i) < low(i) || step(i) > high(i))) {
                places[k] = step(i) < low(i) ? place::at_low : place::at_high;
                step(i) = places[k] == place::at_low ? low(i) : high(i);
                has_changed = true;
            }
        }
        if (has_changed) {
            continue;
        }
        /* One that would rather leave its bound may. */
        const Eigen::VectorXd slope = gradient + hessian * step;
        double strongest = 1e-12 * gradient.cwiseAbs().maxCoeff();
        std::size_t released = size;
        for (std::size_t k = 0; k < size; k++) {
            const double pull = places[k] == place::at_low    ? -slope(static_cast<Eigen::Index>(k))
                                : places[k] == place::at_high ? slope(static_cast<Eigen::Index>(k))
                                                              : 0.0;
            if (pull > strongest) {
                strongest = pull;
                released = k;
            }
        }
        if (released == size) {
            break;
        }
        places[released] = place::free;
    }
    return step.cwiseMax(low).cwiseMin(high);
}

} // namespace berth
