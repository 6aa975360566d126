#include "exponential.h"

#include <unsupported/Eigen/MatrixFunctions>

#include "balance.h"

namespace berth
{

Eigen::MatrixXd balanced_exponential(const Eigen::MatrixXd &a)
{
    Eigen::MatrixXd b = a;
    const Eigen::VectorXd scale = balance(b);
    const Eigen::MatrixXd e = b.exp();
    return scale.asDiagonal() * e * scale.cwiseInverse().asDiagonal();
}

} // namespace berth
