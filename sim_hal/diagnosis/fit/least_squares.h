/* Nonlinear least squares between bounds, with as few evaluations as can be: each is the replay of a record.
 *
 * Levenberg-Marquardt; the step is the minimum of the quadratic model within the bounds, and between fresh ones the
 * Jacobian learns from the steps (Broyden's update, as in Madsen, Nielsen & Tingleff, Methods for Non-Linear Least
 * Squares Problems, 2004, section 3.5). MINPACK's and Eigen's know no bounds: with angles in the place of bounded
 * parameters they took ten times the evaluations, because a parameter hardly moves near its bound. */
#ifndef SIM_HAL_DIAGNOSIS_FIT_LEAST_SQUARES_H
#define SIM_HAL_DIAGNOSIS_FIT_LEAST_SQUARES_H

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <vector>

namespace berth
{

struct least_squares_problem {
    std::function<void(const Eigen::VectorXd &x, Eigen::VectorXd &residual)> residual;
    /* The same at a finite difference beside the last point of `residual`, if that is cheaper there. */
    std::function<void(const Eigen::VectorXd &x, Eigen::VectorXd &residual)> residual_beside;
    Eigen::VectorXd low;
    Eigen::VectorXd high;
    Eigen::VectorXd step; /* of finite differences */
    /* A difference that moves the residual (norm) further is taken again with a smaller step: a frequency turns what
     * it moves round and round. */
    double change_max = std::numeric_limits<double>::infinity();
    Eigen::MatrixXd slopes;           /* Jacobian to begin with, as far as columns are known; else empty */
    std::vector<bool> slope_is_known; /* one a column; empty: none is */
    double tolerance = 1e-5;          /* a decrease of the sum of squares by less than this share ends it */
    int evaluations_max = 100;
    bool is_first_look = false; /* content with a Jacobian that is not fresh, as long as it leads on */
};

struct least_squares_result {
    Eigen::VectorXd x;
    Eigen::VectorXd residual;
    Eigen::MatrixXd jacobian;
    double sum = 0.0; /* of squares */
    int evaluations = 0;
};

least_squares_result solve_least_squares(const least_squares_problem &problem, const Eigen::VectorXd &start);

/* The step with least s'(H + diag(damping)) s / 2 + g's, low <= s <= high: an active-set method. */
Eigen::VectorXd bounded_step(const Eigen::MatrixXd &hessian, const Eigen::VectorXd &gradient,
                             const Eigen::VectorXd &low, const Eigen::VectorXd &high);

} // namespace berth

#endif
