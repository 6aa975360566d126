#include <doctest/doctest.h>

#include <cmath>

#include <Eigen/Core>

#include "firmware/matrix_exponential.h"
#include "seeded.h"
#include "sim_hal/solver/exponential.h"

namespace
{

template <int N>
using matrix = Eigen::Matrix<double, N, N>;

template <int N>
double relative_difference(const matrix<N> &a, const matrix<N> &b)
{
    return (a - b).norm() / b.norm();
}

template <int N>
matrix<N> random_matrix(seeded::engine &random, double scale)
{
    matrix<N> a;
    for (int i = 0; i < N * N; i++) {
        a(i) = scale * seeded::uniform(random, -1.0, 1.0);
    }
    return a;
}

/* Error of an exponential grows with the norm of its argument: one rounding error for each squaring and more. */
template <int N>
void compare_with_eigen(seeded::engine &random)
{
    for (const double scale : {1e-6, 1e-2, 0.2, 0.3, 1.0, 5.0}) {
        for (int i = 0; i < 50; i++) {
            const matrix<N> a = random_matrix<N>(random, scale);
            CAPTURE(scale);
            CHECK(relative_difference<N>(berth::matrix_exponential<N>(a), berth::exponential(a)) <=
                  1e-13 * (1.0 + a.norm()));
        }
    }
}

} // namespace

TEST_CASE("matrix_exponential: agrees with Eigen's Pade approximation")
{
    SEEDED(random, "matrix_exponential:*");
    compare_with_eigen<2>(random);
    compare_with_eigen<5>(random);
}

TEST_CASE("matrix_exponential: closed forms")
{
    CHECK(berth::matrix_exponential<2>(matrix<2>::Zero()) == matrix<2>::Identity());

    matrix<2> diagonal;
    diagonal << 1.0, 0.0, 0.0, -3.0;
    const matrix<2> e = berth::matrix_exponential<2>(diagonal);
    CHECK(e(0, 0) == doctest::Approx(std::exp(1.0)).epsilon(1e-14));
    CHECK(e(1, 1) == doctest::Approx(std::exp(-3.0)).epsilon(1e-14));
    CHECK(e(0, 1) == 0.0);

    for (const double angle : {1e-3, 0.1, 0.7853981633974483, 3.0, 20.0}) {
        CAPTURE(angle);
        matrix<2> turn, expected;
        turn << 0.0, -angle, angle, 0.0;
        expected << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
        CHECK(relative_difference<2>(berth::matrix_exponential<2>(turn), expected) <= 1e-14 * (1.0 + 4.0 * angle));
    }

    matrix<5> shift = matrix<5>::Zero(); /* nilpotent: exp is a polynomial, t^k / k! on the k-th diagonal */
    for (int i = 0; i < 4; i++) {
        shift(i, i + 1) = 2.0;
    }
    const matrix<5> polynomial = berth::matrix_exponential<5>(shift);
    CHECK(polynomial(0, 4) == doctest::Approx(16.0 / 24.0).epsilon(1e-14));
    CHECK(polynomial(0, 3) == doctest::Approx(8.0 / 6.0).epsilon(1e-14));
    CHECK(polynomial(4, 0) == 0.0);
}

TEST_CASE("matrix_exponential: exp(A) exp(-A) = 1 and det exp(A) = exp(trace A)")
{
    SEEDED(random, "matrix_exponential:*");
    for (int i = 0; i < 100; i++) {
        const matrix<2> a = random_matrix<2>(random, 2.0);
        const matrix<2> e = berth::matrix_exponential<2>(a);
        CHECK(relative_difference<2>(e * berth::matrix_exponential<2>(-a), matrix<2>::Identity()) <=
              1e-13 * e.norm());
        const double determinant = e(0, 0) * e(1, 1) - e(0, 1) * e(1, 0);
        CHECK(determinant == doctest::Approx(std::exp(a.trace())).epsilon(1e-12));
    }
}
