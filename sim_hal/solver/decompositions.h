/* Eigen's decompositions of matrices of any size that several files need, compiled once: in each of them they would
 * be most of what a build waits for. */
#ifndef SIM_HAL_SOLVER_DECOMPOSITIONS_H
#define SIM_HAL_SOLVER_DECOMPOSITIONS_H

#include <Eigen/Core>

namespace berth
{

/* Of a square matrix, in the order of its Schur form. Balance it first where its rows differ in size. */
Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd &matrix);

/* Square and orthonormal: the first columns span those given (of full rank), the others are across them. */
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd &columns);

/* Orthonormal; its columns span those given, as many as these have rank. */
Eigen::MatrixXd column_space(const Eigen::MatrixXd &columns);

/* x of a x = b by least squares, for each column of b; for more rows than columns. */
Eigen::MatrixXd least_squares_solution(const Eigen::MatrixXd &a, const Eigen::MatrixXd &b);

/* The least x that solves a x = b by least squares; for any rank. */
Eigen::VectorXd least_norm_solution(const Eigen::MatrixXd &a, const Eigen::VectorXd &b);

} // namespace berth

#endif
