/* Single zeros of the loop's characteristic equation F(w), w = 1/z, without the others. */
#ifndef SIM_HAL_STABILITY_CRITICAL_ZERO_H
#define SIM_HAL_STABILITY_CRITICAL_ZERO_H

#include <complex>

#include "loop_equation.h"

namespace berth
{

/* The zero of F near w, by Newton. */
std::complex<double> zero_near(const loop_equation &equation, std::complex<double> w);

/* The zero next to the unit circle: the mode that goes, where the loop is about to lose its stability. */
std::complex<double> zero_next_to_unit_circle(const loop_equation &equation);

} // namespace berth

#endif
