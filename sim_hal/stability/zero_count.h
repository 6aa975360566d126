/* How many zeros the characteristic equation has inside a circle, by the argument principle. The power of the dead
 * time turns at a rate that is known, so that only A and B have to be sampled: the cost does not depend on it. */
#ifndef SIM_HAL_STABILITY_ZERO_COUNT_H
#define SIM_HAL_STABILITY_ZERO_COUNT_H

#include <complex>
#include <vector>

#include "loop_equation.h"

namespace berth
{

/* Where a zero of A lies on the circle, as that of an undamped or free body does, a circle that is smaller by this
 * share is taken. */
constexpr double count_margin = 1e-10;

/* Zeros with |w| < radius, multiple ones as often as they are. If `starts` is given: for every zero of the upper
 * half plane near the circle, a point from which Newton's method finds it. */
int count_zeros_inside(const loop_equation &equation, double radius,
                       std::vector<std::complex<double>> *starts = nullptr);

} // namespace berth

#endif
