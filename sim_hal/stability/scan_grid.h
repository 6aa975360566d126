/* The values at which a parameter of the rig is looked at, and bisection between two of them. */
#ifndef SIM_HAL_STABILITY_SCAN_GRID_H
#define SIM_HAL_STABILITY_SCAN_GRID_H

#include <functional>
#include <vector>

#include "limits.h"
#include "physical_parameter.h"

namespace berth
{

/* Bisection ends here: relative, far below the 6 digits that are told. */
constexpr double bisection_tolerance = 1e-11;

/* Halves [good, bad] until it is as narrow as rounding lets it be; both ends keep what `is_good` says of them. */
void bisect(double &good, double &bad, const std::function<bool(double)> &is_good,
            double tolerance = bisection_tolerance);

/* Along a delay the eigenvalues swing once a period of the loop: no step, in the parameter's unit, is longer than a
 * part of it. */
double longest_step(const rig &rig, parameter_scale kind, double range, const scan &how);

/* Values to look at, rising: a logarithmic grid, finer for delays, the permitted smallest value, and the rig's
 * `own`. */
std::vector<double> scan_grid(const rig &rig, const rig_key &key, parameter_scale kind, double own, const scan &how);

} // namespace berth

#endif
