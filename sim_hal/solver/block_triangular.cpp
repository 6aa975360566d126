#include "block_triangular.h"

namespace berth
{

block_triangular<7> operator*(const block_triangular<7> &a, const block_triangular<7> &b)
{
    block_triangular<7> product;
    for (int column = 0; column < 7; column++) {
        for (int row = 0; row <= column; row++) {
            block sum{};
            for (int k = row; k <= column; k++) {
                sum.columns[0] += a.at(row, k) * b.at(k, column).columns[0];
                sum.columns[1] += a.at(row, k) * b.at(k, column).columns[1];
            }
            product.at(row, column) = sum;
        }
    }
    return product;
}

} // namespace berth
