/* Up to which share of the force the loop may be closed: from the eigenvalues of the loop at each share. */
#ifndef SIM_HAL_COMMISSION_GAIN_LIMIT_H
#define SIM_HAL_COMMISSION_GAIN_LIMIT_H

#include <functional>
#include <optional>

#include "../../hal/rig/rig.h"

namespace berth
{

/* The rig with so much of its force fed back, 0 to 1. */
rig with_feedback_gain(const rig &whole, double gain);

/* Smallest damping ratio of all modes of the loop; less than 0: one of them grows. Throws input_error where the rig
 * has no eigenvalues. */
double least_damping_ratio(const rig &rig);

/* The smallest gain up to `most` at which `damping` falls below `margin`, to 1e-4; nothing: at none of them. Looked
 * for in steps of a fiftieth. */
std::optional<double> gain_limit(const std::function<double(double gain)> &damping, double margin,
                                 double most = 1.0);

} // namespace berth

#endif
