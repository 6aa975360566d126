/* What a force sensor shows of a load, by its mounting and its crosstalk. */
#ifndef HAL_RIG_WRENCH_MATRIX_H
#define HAL_RIG_WRENCH_MATRIX_H

#include "rig.h"

namespace berth
{

/* Row-major: (force, torque) as shown = this * (force, torque) on the object in the robot's frame, about the tool's
 * point. */
using wrench_matrix = std::array<double, 36>;
wrench_matrix shown_wrench(const wrench_rig &wrench);

} // namespace berth

#endif
