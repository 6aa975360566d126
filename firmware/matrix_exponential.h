/* exp(A) for small fixed-size matrices from additions, multiplications and one division: the same bits on every
 * machine with IEEE arithmetic, which a libm would not promise. Start-up only.
 * Scaling and squaring with a Taylor series: at norm <= 1/4, 14 terms leave 1e-20. Lazy products: from a size on,
 * Eigen's others may use the heap. */
#ifndef FIRMWARE_MATRIX_EXPONENTIAL_H
#define FIRMWARE_MATRIX_EXPONENTIAL_H

#include <Eigen/Core>

namespace berth
{

template <int N>
Eigen::Matrix<double, N, N> matrix_exponential(Eigen::Matrix<double, N, N> a)
{
    constexpr int terms = 14;
    constexpr int squarings_max = 64;
    double norm = a.cwiseAbs().rowwise().sum().maxCoeff();
    int squarings = 0;
    while (norm > 0.25 && squarings < squarings_max) {
        norm *= 0.5;
        a *= 0.5;
        squarings++;
    }
    const auto identity = Eigen::Matrix<double, N, N>::Identity();
    Eigen::Matrix<double, N, N> sum = identity;
    for (int k = terms; k > 0; k--) {
        sum = identity + a.lazyProduct(sum).eval() / static_cast<double>(k);
    }
    for (int i = 0; i < squarings; i++) {
        sum = sum.lazyProduct(sum).eval();
    }
    return sum;
}

} // namespace berth

#endif
