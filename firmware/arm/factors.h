/* Cholesky factors of the small symmetric matrices of an arm, compiled once. Fixed sizes, no heap. */
#ifndef FIRMWARE_ARM_FACTORS_H
#define FIRMWARE_ARM_FACTORS_H

#include <Eigen/Core>

namespace berth
{

template <int size>
using symmetric_matrix = Eigen::Matrix<double, size, size>;
template <int size>
using symmetric_side = Eigen::Matrix<double, size, 1>;

template <int size>
bool is_positive_definite(const symmetric_matrix<size> &a);

/* x of a x = b, for a positive definite `a`. */
template <int size>
symmetric_side<size> positive_solution(const symmetric_matrix<size> &a, const symmetric_side<size> &b);

/* x of a x = b, for an `a` that may be near to singular: with pivots. */
template <int size>
symmetric_side<size> semidefinite_solution(const symmetric_matrix<size> &a, const symmetric_side<size> &b);

/* Of the same factors: 0 where `a` is singular. */
template <int size>
double least_pivot(const symmetric_matrix<size> &a);

} // namespace berth

#endif
