/* The characteristic equation of the loop, with its dead time as a power instead of as states:
 *
 *     F(w) = A(w) + w^delay B(w) = 0,   w = 1/z
 *
 * A: poles of manipulator, inverse filter and hardware; B: their zeros. The degrees of A and B do not depend on the
 * dead time, so that F costs the same to evaluate at 8 samples of dead time as at 400. Every zero of F is the
 * inverse of an eigenvalue of the one-period map, and every eigenvalue but 0 is found so. */
#ifndef SIM_HAL_STABILITY_LOOP_EQUATION_H
#define SIM_HAL_STABILITY_LOOP_EQUATION_H

#include <array>
#include <complex>

#include "../../hal/rig/rig.h"

namespace berth
{

/* Coefficients by rising powers of w. */
struct short_polynomial {
    static constexpr int capacity = 14;
    std::array<double, capacity> coefficients{};
    int degree = 0;
};

struct loop_equation {
    short_polynomial a;
    short_polynomial b;
    int delay = 0;

    int degree() const;
};

/* F, and its derivative by w. */
struct equation_value {
    std::complex<double> value;
    std::complex<double> slope;
};

equation_value evaluate(const loop_equation &equation, std::complex<double> w);

/* Of a rig that has a one-period map; throws input_error otherwise. Uses no heap. */
loop_equation make_loop_equation(const rig &rig);

} // namespace berth

#endif
