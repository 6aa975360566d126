/* Setpoint to sample near z = 1. At a high rate several pairs of poles and zeros lie there, each as near as its
 * frequency counts in rad per period: multiplied out by powers of 1/z nothing but rounding is left of them. By
 * powers of z - 1 they keep their digits. */
#ifndef SIM_HAL_STABILITY_SLOW_RESPONSE_H
#define SIM_HAL_STABILITY_SLOW_RESPONSE_H

#include "hardware_period.h"
#include "short_polynomial.h"

namespace berth
{

/* q by powers of d = z - 1: hardware_zeros(w) = w^degree q, see loop_equation.cpp. */
short_polynomial slow_response(const hardware_period &hardware);

} // namespace berth

#endif
