#include "factors.h"

#include <algorithm>
#include <Eigen/Cholesky>

namespace berth
{

template <int size>
bool is_positive_definite(const symmetric_matrix<size> &a)
{
    return a.llt().info() == Eigen::Success;
}

template <int size>
symmetric_side<size> positive_solution(const symmetric_matrix<size> &a, const symmetric_side<size> &b)
{
    return a.llt().solve(b);
}

template <int size>
symmetric_side<size> semidefinite_solution(const symmetric_matrix<size> &a, const symmetric_side<size> &b)
{
    return a.ldlt().solve(b);
}

template <int size>
double least_pivot(const symmetric_matrix<size> &a)
{
    return std::max(a.ldlt().vectorD().minCoeff(), 0.0);
}

/* Twists have three parts in the plane and six in space. */
#define FOR_EACH_SIZE(X) X(3) X(6)
#define INSTANTIATE_FACTORS(size)                                                                                   \
    template bool is_positive_definite<size>(const symmetric_matrix<size> &);                                       \
    template symmetric_side<size> positive_solution<size>(const symmetric_matrix<size> &,                           \
                                                          const symmetric_side<size> &);                            \
    template symmetric_side<size> semidefinite_solution<size>(const symmetric_matrix<size> &,                       \
                                                              const symmetric_side<size> &);                        \
    template double least_pivot<size>(const symmetric_matrix<size> &);
FOR_EACH_SIZE(INSTANTIATE_FACTORS)

} // namespace berth
