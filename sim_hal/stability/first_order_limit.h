/* The damping limit of the slow mode to first order in the loop's delay: a closed form beside the exact answer. */
#ifndef SIM_HAL_STABILITY_FIRST_ORDER_LIMIT_H
#define SIM_HAL_STABILITY_FIRST_ORDER_LIMIT_H

#include "../../hal/rig/rig.h"

namespace berth
{

/* How late a slow motion of the manipulator comes back to it as a force, in s: dead time, the age of the force
 * sample, half a period of force held (and of setpoint held), and the phase lags of robot, inverse filter and
 * low-pass. */
double loop_delay_s(const rig &rig);

/* Damping ratio of the coupled system that the delay t takes off:
 *     (t/2) M/(M + m) (w - w_M^2/w),  w^2 = (K + k)/(M + m),  w_M^2 = K/M
 * Not positive where w <= w_M: there the slow mode never becomes unstable. */
double first_order_damping_limit(const rig &rig);

/* Damping ratio of the coupled system less its limit: the slow mode is stable where this is positive. */
double first_order_damping_margin(const rig &rig);

} // namespace berth

#endif
