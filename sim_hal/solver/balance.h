/* Makes rows and columns of a badly scaled matrix alike in size: metres beside newtons behind a stiff spring. */
#ifndef SIM_HAL_SOLVER_BALANCE_H
#define SIM_HAL_SOLVER_BALANCE_H

#include <Eigen/Core>

namespace berth
{

/* Replaces b by D^-1 b D and returns the diagonal of D, powers of two, so that nothing is rounded (Osborne 1960).
 * Eigenvalues stay what they are. */
Eigen::VectorXd balance(Eigen::MatrixXd &b);

} // namespace berth

#endif
