/* The largest eigenvalue of a large matrix with few entries, from products with a vector. */
#ifndef SIM_HAL_SOLVER_POWER_ITERATION_H
#define SIM_HAL_SOLVER_POWER_ITERATION_H

#include <Eigen/Core>

namespace berth
{

/* Estimate of the largest |eigenvalue| of a square matrix: how fast a vector grows once its other parts have decayed
 * (power iteration), as the slope of ln(length), so that the swing of a complex pair averages out. */
double power_radius(const Eigen::MatrixXd &matrix);

} // namespace berth

#endif
