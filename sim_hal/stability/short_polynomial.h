/* Polynomials of few coefficients, without heap. */
#ifndef SIM_HAL_STABILITY_SHORT_POLYNOMIAL_H
#define SIM_HAL_STABILITY_SHORT_POLYNOMIAL_H

#include <array>
#include <cstddef>

namespace berth
{

/* Coefficients by rising powers. */
struct short_polynomial {
    static constexpr int capacity = 28;
    std::array<double, capacity> coefficients{};
    int degree = 0;
};

/* Times c0 + c1 w + c2 w^2. */
struct short_factor {
    double c0;
    double c1;
    double c2;
    int degree;
};

/* By the rising powers before `end`. */
inline void multiply(double *p, int end, const short_factor &f)
{
    double before = 0.0;
    double before_that = 0.0;
    for (int i = 0; i < end; i++) {
        const double here = p[i];
        p[i] = f.c0 * here + f.c1 * before + f.c2 * before_that;
        before_that = before;
        before = here;
    }
}

inline void multiply(short_polynomial &p, const short_factor &f)
{
    p.degree += f.degree;
    multiply(p.coefficients.data(), p.degree + 1, f);
}

} // namespace berth

#endif
