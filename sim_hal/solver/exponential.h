/* exp(A) for badly scaled generators: metres beside newtons behind a spring of 2e7 N/m. */
#ifndef SIM_HAL_SOLVER_EXPONENTIAL_H
#define SIM_HAL_SOLVER_EXPONENTIAL_H

#include <Eigen/Core>

namespace berth
{

/* Balances A by powers of two first, so that rows and columns are of like size (Osborne): without it, scaling and
 * squaring of the plant's generator loses twelve digits. */
Eigen::MatrixXd balanced_exponential(const Eigen::MatrixXd &a);

} // namespace berth

#endif
