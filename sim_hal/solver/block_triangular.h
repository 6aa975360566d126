/* Block upper triangular matrices of 2x2 blocks, as chains of second-order systems have them, each link driven by
 * those after it; and their exponential. Half the products of a full matrix are products with zero and left out. */
#ifndef SIM_HAL_SOLVER_BLOCK_TRIANGULAR_H
#define SIM_HAL_SOLVER_BLOCK_TRIANGULAR_H

#include <algorithm>
#include <array>
#include <cmath>

namespace berth
{

/* The same operations, so the same bits, in fewer instructions where the processor has AVX. */
#if defined(__x86_64__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define BERTH_AVX_IF_THERE __attribute__((target_clones("avx", "default")))
#else
#define BERTH_AVX_IF_THERE
#endif

/* Two numbers that one instruction works on; GCC and Clang have it on every processor. */
using pair_vector = double __attribute__((vector_size(16)));

struct two_by_two {
    std::array<pair_vector, 2> columns; /* not set to 0 by itself */

    double operator()(int row, int column) const { return columns[static_cast<std::size_t>(column)][row]; }
    double trace() const { return columns[0][0] + columns[1][1]; }
    double determinant() const { return columns[0][0] * columns[1][1] - columns[1][0] * columns[0][1]; }
};

inline pair_vector operator*(const two_by_two &a, pair_vector x)
{
    return a.columns[0] * x[0] + a.columns[1] * x[1];
}

template <int count>
struct block_triangular {
    std::array<two_by_two, count *(count + 1) / 2> blocks; /* column by column, each down to the diagonal */

    static constexpr std::size_t place(int row, int column)
    {
        return static_cast<std::size_t>(column) * (static_cast<std::size_t>(column) + 1) / 2 +
               static_cast<std::size_t>(row);
    }
    two_by_two &at(int row, int column) { return blocks[place(row, column)]; }
    const two_by_two &at(int row, int column) const { return blocks[place(row, column)]; }

    /* Calls f(row, column) for every block that is not 0. */
    template <typename function>
    static void for_each(const function &f)
    {
#pragma GCC unroll 4
        for (int row = 0; row < count; row++) {
#pragma GCC unroll 4
            for (int column = row; column < count; column++) {
                f(row, column);
            }
        }
    }
};

template <int count>
block_triangular<count> operator*(const block_triangular<count> &a, const block_triangular<count> &b)
{
    block_triangular<count> product;
    product.for_each([&](int row, int column) {
        two_by_two sum{a.at(row, row) * b.at(row, column).columns[0], a.at(row, row) * b.at(row, column).columns[1]};
#pragma GCC unroll 4
        for (int k = row + 1; k <= column; k++) {
            sum.columns[0] += a.at(row, k) * b.at(k, column).columns[0];
            sum.columns[1] += a.at(row, k) * b.at(k, column).columns[1];
        }
        product.at(row, column) = sum;
    });
    return product;
}

/* The same for long chains, not unrolled: they are rare, and take minutes to compile otherwise. */
block_triangular<7> operator*(const block_triangular<7> &a, const block_triangular<7> &b);
block_triangular<13> operator*(const block_triangular<13> &a, const block_triangular<13> &b);

/* Largest sum of a column's magnitudes. */
template <int count>
double norm(const block_triangular<count> &a)
{
    double largest = 0.0;
    for (int column = 0; column < count; column++) {
        for (int side = 0; side < 2; side++) {
            double sum = 0.0;
            for (int row = 0; row <= column; row++) {
                sum += std::abs(a.at(row, column)(0, side)) + std::abs(a.at(row, column)(1, side));
            }
            largest = std::max(largest, sum);
        }
    }
    return largest;
}

/* exp(a) - 1, which keeps all digits where a is small: the Taylor series to degree 16 (at norm 1 the rest is 3e-15)
 * in powers of a^4 (Paterson and Stockmeyer 1973), after scaling and before squaring. */
template <int count>
BERTH_AVX_IF_THERE block_triangular<count> exponential_minus_identity(const block_triangular<count> &a)
{
    constexpr double factorials[] = {
        1.,      1.,       2.,        6.,         24.,         120.,         720.,           5040.,          40320.,
        362880., 3628800., 39916800., 479001600., 6227020800., 87178291200., 1307674368000., 20922789888000.};
    int squarings = 0;
    std::frexp(norm(a), &squarings); /* norm < 2^squarings */
    squarings = std::clamp(squarings, 0, 60);
    const double scale = std::ldexp(1.0, -squarings);
    block_triangular<count> a1 = a;
    a1.for_each([&](int row, int column) {
        a1.at(row, column).columns[0] *= scale;
        a1.at(row, column).columns[1] *= scale;
    });
    const block_triangular<count> a2 = a1 * a1;
    const block_triangular<count> a3 = a2 * a1;
    const block_triangular<count> a4 = a2 * a2;

    /* sum += 1/n! + a/(n+1)! + a^2/(n+2)! + a^3/(n+3)!, without 1/n! for n = 0 */
    const auto add_terms = [&](block_triangular<count> &sum, int n) {
        const double c1 = 1.0 / factorials[n + 1];
        const double c2 = 1.0 / factorials[n + 2];
        const double c3 = 1.0 / factorials[n + 3];
        sum.for_each([&](int row, int column) {
#pragma GCC unroll 2
            for (std::size_t i = 0; i < 2; i++) {
                sum.at(row, column).columns[i] += c1 * a1.at(row, column).columns[i] +
                                                  c2 * a2.at(row, column).columns[i] +
                                                  c3 * a3.at(row, column).columns[i];
            }
        });
        const double c0 = n > 0 ? 1.0 / factorials[n] : 0.0;
#pragma GCC unroll 4
        for (int i = 0; i < count; i++) {
            sum.at(i, i).columns[0][0] += c0;
            sum.at(i, i).columns[1][1] += c0;
        }
    };
    block_triangular<count> sum = a4;
    sum.for_each([&](int row, int column) {
        sum.at(row, column).columns[0] /= factorials[16];
        sum.at(row, column).columns[1] /= factorials[16];
    });
    add_terms(sum, 12);
    sum = a4 * sum;
    add_terms(sum, 8);
    sum = a4 * sum;
    add_terms(sum, 4);
    sum = a4 * sum;
    add_terms(sum, 0);

    for (int i = 0; i < squarings; i++) { /* (1 + e)^2 - 1 = 2 e + e^2 */
        const block_triangular<count> square = sum * sum;
        sum.for_each([&](int row, int column) {
            sum.at(row, column).columns[0] += sum.at(row, column).columns[0] + square.at(row, column).columns[0];
            sum.at(row, column).columns[1] += sum.at(row, column).columns[1] + square.at(row, column).columns[1];
        });
    }
    return sum;
}

} // namespace berth

#endif
