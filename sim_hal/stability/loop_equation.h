/* The characteristic equation of the loop, with its dead time as a power instead of as states:
 *
 *     F(w) = A(w) + w^delay B(w) = 0,   w = 1/z
 *
 * A: poles of manipulator, inverse filter and hardware; B: their zeros. The degrees of A and B do not depend on the
 * dead time, so that F costs the same to evaluate at 8 samples of dead time as at 400. Every zero of F is the
 * inverse of an eigenvalue of the one-period map, and every eigenvalue but 0 is found so. */
#ifndef SIM_HAL_STABILITY_LOOP_EQUATION_H
#define SIM_HAL_STABILITY_LOOP_EQUATION_H

#include <algorithm>
#include <array>
#include <complex>

#include "../../hal/rig/rig.h"
#include "hardware_chain.h"
#include "short_polynomial.h"

namespace berth
{

/* c0 + c1 e + c2 e^2 with e = 1 - w: a slow pole or zero sits at w = 1 but for a little, and keeps its digits. */
struct slow_factor {
    double c0;
    double c1;
    double c2;
};

struct loop_equation {
    int delay = 0;

    /* A is the product of its factors; B that of two. */
    std::array<slow_factor, hardware_chain::links_max + 2> a_factors;
    int a_factor_count = 0;
    slow_factor b_factor{1.0, 0.0, 0.0};
    short_polynomial b_rest; /* by powers of w */

    /* Near w = 1, where next to nothing is left of b_rest: b_rest = w^degree b_slow, by powers of z - 1. */
    bool has_b_slow = false;
    short_polynomial b_slow;

    /* A and B multiplied out. Rounding moves the zeros near w = 1 by more than the factors do: use evaluate(). */
    short_polynomial a;
    short_polynomial b;

    int degree() const { return std::max(a.degree, delay + b.degree); }
};

/* A, B and their derivatives by w. */
struct equation_parts {
    std::complex<double> a;
    std::complex<double> a_slope;
    std::complex<double> b;
    std::complex<double> b_slope;
};

equation_parts evaluate_parts(const loop_equation &equation, std::complex<double> w);

/* F, and its derivative by w. */
struct equation_value {
    std::complex<double> value;
    std::complex<double> slope;
};

equation_value evaluate(const loop_equation &equation, std::complex<double> w);

/* Not so where a spring softens so far that a period of its motion overflows. */
bool is_finite(const loop_equation &equation);

/* Roots w of a factor, inf where there is none. */
std::array<std::complex<double>, 2> roots_of(const slow_factor &factor);

/* w^n. */
std::complex<double> power(std::complex<double> w, int n);

/* Of a rig that has a one-period map; throws input_error otherwise. Uses no heap. */
loop_equation make_loop_equation(const rig &rig);

/* The same for many rigs of which each differs little from the one before: what depends on the firmware alone is
 * made again only if its part of the rig has changed. */
class loop_equation_maker
{
  public:
    loop_equation make(const rig &rig);

  private:
    struct firmware_response {
        std::array<double, 2> zeros{}; /* of the manipulator: -F to x, without the one w that every step takes */
        slow_factor poles;
        bool has_filter = false;
        std::array<double, 3> filter_zeros{}; /* by powers of w */
        std::array<double, 3> filter_poles{};
    };
    static firmware_response respond(const app_config &config);

    bool has_response_ = false;
    loop_config loop_{};
    manipulator_config manipulator_{};
    inverse_filter_config filter_{};
    firmware_response response_;
};

} // namespace berth

#endif
