/* exp(A), compiled once. */
#ifndef SIM_HAL_SOLVER_EXPONENTIAL_H
#define SIM_HAL_SOLVER_EXPONENTIAL_H

#include <Eigen/Core>

namespace berth
{

/* Of a matrix whose rows are of like size. */
Eigen::MatrixXd exponential(const Eigen::MatrixXd &a);

/* For badly scaled generators: metres beside newtons behind a spring of 2e7 N/m. Balances A by powers of two first,
 * so that rows and columns are of like size (Osborne): without it, scaling and squaring of the plant's generator
 * loses twelve digits. */
Eigen::MatrixXd balanced_exponential(const Eigen::MatrixXd &a);

} // namespace berth

#endif
