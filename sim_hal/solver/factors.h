/* Solutions of square systems of any size by Eigen's triangular factors, compiled once, as decompositions.h. */
#ifndef SIM_HAL_SOLVER_FACTORS_H
#define SIM_HAL_SOLVER_FACTORS_H

#include <Eigen/Core>

namespace berth
{

/* x of a x = b, for each column of b; for any `a` that can be inverted. */
Eigen::MatrixXd solution(const Eigen::MatrixXd &a, const Eigen::MatrixXd &b);
Eigen::MatrixXd inverse(const Eigen::MatrixXd &a);

/* The columns span what `a` maps to zero: pivots below `threshold` times the largest count as zero. */
Eigen::MatrixXd kernel(const Eigen::MatrixXd &a, double threshold);

/* x of a x = b for a symmetric, positive definite `a` (Cholesky). */
Eigen::VectorXd positive_solution(const Eigen::MatrixXd &a, const Eigen::VectorXd &b);
Eigen::MatrixXd positive_solutions(const Eigen::MatrixXd &a, const Eigen::MatrixXd &b);
Eigen::MatrixXd positive_inverse(const Eigen::MatrixXd &a);

/* Upper u with a = u^T u. */
Eigen::MatrixXd upper_root(const Eigen::MatrixXd &a);

/* x of a x = b for a symmetric `a` that is positive semidefinite (Cholesky with pivots). */
Eigen::VectorXd semidefinite_solution(const Eigen::MatrixXd &a, const Eigen::VectorXd &b);

} // namespace berth

#endif
