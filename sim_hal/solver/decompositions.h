/* Eigen's decompositions of matrices of any size, compiled once: in each file that needs them they would be most of
 * what a build waits for. Host code decomposes matrices through this header and factors.h alone; lint holds it. */
#ifndef SIM_HAL_SOLVER_DECOMPOSITIONS_H
#define SIM_HAL_SOLVER_DECOMPOSITIONS_H

#include <Eigen/Core>

namespace berth
{

/* Of a square matrix, in the order of its Schur form. Balance it first where its rows differ in size. */
Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd &matrix);

/* a = u t u^T with an orthogonal u and an upper t that has 2x2 blocks where eigenvalues are complex. */
struct schur_form {
    Eigen::MatrixXd t;
    Eigen::MatrixXd u;
};
schur_form real_schur(const Eigen::MatrixXd &a);

/* Of a v = lambda b v, both symmetric and b positive definite: ascending, and v^T b v = 1. */
struct eigenpairs {
    Eigen::VectorXd values;
    Eigen::MatrixXd vectors;
};
eigenpairs generalised_eigenpairs(const Eigen::MatrixXd &a, const Eigen::MatrixXd &b);

/* Of a symmetric matrix, of which the lower half is read: ascending. */
eigenpairs symmetric_eigenpairs(const Eigen::MatrixXd &a);

/* The unit vector that a square matrix shortens most. */
Eigen::VectorXcd least_singular_vector(const Eigen::MatrixXcd &a);

/* Square and orthonormal: the first columns span those given (of full rank), the others are across them. */
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd &columns);

/* Orthonormal; its columns span those given, as many as these have rank. */
Eigen::MatrixXd column_space(const Eigen::MatrixXd &columns);

/* x of a x = b by least squares, for each column of b; for more rows than columns. */
Eigen::MatrixXd least_squares_solution(const Eigen::MatrixXd &a, const Eigen::MatrixXd &b);

/* The same without pivoting, for an `a` of full rank. */
Eigen::VectorXd full_rank_least_squares(const Eigen::MatrixXd &a, const Eigen::VectorXd &b);

/* The least x that solves a x = b by least squares; for any rank. */
Eigen::VectorXd least_norm_solution(const Eigen::MatrixXd &a, const Eigen::VectorXd &b);

} // namespace berth

#endif
