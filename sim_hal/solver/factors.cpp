#include "factors.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace berth
{

Eigen::MatrixXd solution(const Eigen::MatrixXd &a, const Eigen::MatrixXd &b)
{
    return a.partialPivLu().solve(b);
}

Eigen::MatrixXd inverse(const Eigen::MatrixXd &a)
{
    return a.inverse();
}

Eigen::MatrixXd kernel(const Eigen::MatrixXd &a, double threshold)
{
    Eigen::FullPivLU<Eigen::MatrixXd> factors(a);
    factors.setThreshold(threshold);
    return factors.kernel();
}

Eigen::VectorXd positive_solution(const Eigen::MatrixXd &a, const Eigen::VectorXd &b)
{
    return a.llt().solve(b);
}

Eigen::MatrixXd positive_solutions(const Eigen::MatrixXd &a, const Eigen::MatrixXd &b)
{
    return a.llt().solve(b);
}

Eigen::MatrixXd positive_inverse(const Eigen::MatrixXd &a)
{
    return positive_solutions(a, Eigen::MatrixXd::Identity(a.rows(), a.cols()));
}

Eigen::MatrixXd upper_root(const Eigen::MatrixXd &a)
{
    return a.llt().matrixU();
}

Eigen::VectorXd semidefinite_solution(const Eigen::MatrixXd &a, const Eigen::VectorXd &b)
{
    return a.ldlt().solve(b);
}

} // namespace berth
