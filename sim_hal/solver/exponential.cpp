#include "exponential.h"

#include <unsupported/Eigen/MatrixFunctions>

#include "balance.h"

namespace berth
{

Eigen::MatrixXd exponential(const Eigen::MatrixXd &a)
{
    return a.exp();
}

Eigen::MatrixXd balanced_exponential(const Eigen::MatrixXd &a)
{
    Eigen::MatrixXd b = a;
    const Eigen::VectorXd scale = balance(b);
    const Eigen::MatrixXd e = exponential(b);
    return scale.asDiagonal() * e * scale.cwiseInverse().asDiagonal();
}

} // namespace berth
