#include "block_triangular.h"

namespace berth
{

namespace
{

template <int count>
block_triangular<count> product_of(const block_triangular<count> &a, const block_triangular<count> &b)
{
    block_triangular<count> product;
    for (int column = 0; column < count; column++) {
        for (int row = 0; row <= column; row++) {
            two_by_two sum{};
            for (int k = row; k <= column; k++) {
                sum.columns[0] += a.at(row, k) * b.at(k, column).columns[0];
                sum.columns[1] += a.at(row, k) * b.at(k, column).columns[1];
            }
            product.at(row, column) = sum;
        }
    }
    return product;
}

} // namespace

block_triangular<7> operator*(const block_triangular<7> &a, const block_triangular<7> &b)
{
    return product_of(a, b);
}

block_triangular<13> operator*(const block_triangular<13> &a, const block_triangular<13> &b)
{
    return product_of(a, b);
}

} // namespace berth
