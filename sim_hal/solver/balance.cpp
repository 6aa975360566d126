#include "balance.h"

#include <cmath>

namespace berth
{

Eigen::VectorXd balance(Eigen::MatrixXd &b)
{
    constexpr int sweeps_max = 50;
    Eigen::VectorXd scale = Eigen::VectorXd::Ones(b.rows());
    for (int sweep = 0, changed = 1; changed != 0 && sweep < sweeps_max; sweep++) {
        changed = 0;
        for (Eigen::Index i = 0; i < b.rows(); i++) {
            const double column = b.col(i).cwiseAbs().sum() - std::abs(b(i, i));
            const double row = b.row(i).cwiseAbs().sum() - std::abs(b(i, i));
            if (column == 0.0 || row == 0.0) {
                continue;
            }
            const double factor = std::exp2(std::round(0.5 * std::log2(row / column)));
            if (factor != 1.0) {
                b.col(i) *= factor;
                b.row(i) /= factor;
                scale(i) *= factor;
                changed = 1;
            }
        }
    }
    return scale;
}

} // namespace berth
