#include "arm_period.h"

#include <Eigen/Core>

#include "../solver/factors.h"

namespace berth
{

namespace
{

/* A step of x' = rates x; the rows of the first `positions` are x1' = x2. `rates` has the inputs as states that
 * stay. Formulas: Hairer, Lubich & Wanner, Geometric Numerical Integration, I and II. */
Eigen::MatrixXd step_of(arm_integrator integrator, const Eigen::MatrixXd &rates, Eigen::Index positions,
                        double step_s)
{
    const Eigen::MatrixXd stay = Eigen::MatrixXd::Identity(rates.rows(), rates.cols());
    const Eigen::MatrixXd way = rates * step_s;
    switch (integrator) {
    case ARM_SEMI_IMPLICIT_EULER: {
        Eigen::MatrixXd faster = stay;
        faster.middleRows(positions, positions) += way.middleRows(positions, positions);
        Eigen::MatrixXd moved = stay;
        moved.topRows(positions) += way.topRows(positions);
        return moved * faster;
    }
    case ARM_RK4:
        return stay + way * (stay + way / 2.0 * (stay + way / 3.0 * (stay + way / 4.0)));
    default:
        return solution(stay - 0.5 * way, stay + 0.5 * way);
    }
}

} // namespace

arm_period period_of(const linear_arm &arm, const arm_config &config, const Eigen::MatrixXd &ways, double period_s)
{
    const Eigen::Index n = arm.count();
    const Eigen::VectorXd scale = arm.inertia.diagonal().cwiseSqrt().cwiseInverse();
    const auto even = [&](const Eigen::MatrixXd &matrix) {
        return Eigen::MatrixXd(scale.asDiagonal() * matrix * scale.asDiagonal());
    };
    const Eigen::MatrixXd way = ways * scale.asDiagonal();
    const Eigen::Index axes = way.rows();
    const Eigen::MatrixXd inertia = even(arm.inertia);
    /* Inputs: the loads along the axes, and the attitude control's force on each q. */
    Eigen::MatrixXd rates = Eigen::MatrixXd::Zero(3 * n + axes, 3 * n + axes);
    rates.block(0, n, n, n).setIdentity();
    rates.block(n, 0, n, n) = -positive_solutions(inertia, even(arm.stiffness - arm.attitude_stiffness));
    rates.block(n, n, n, n) = -positive_solutions(inertia, even(arm.damping - arm.attitude_damping));
    rates.block(n, 2 * n, n, axes) = positive_solutions(inertia, way.transpose());
    rates.block(n, 2 * n + axes, n, n) = positive_inverse(inertia);
    const double step_s = period_s / static_cast<double>(config.substeps);
    const Eigen::MatrixXd step = step_of(static_cast<arm_integrator>(config.integrator), rates, n, step_s);
    Eigen::MatrixXd over = step;
    for (int64_t i = 1; i < config.substeps; i++) {
        over = step * over;
    }
    arm_period result = {over.topLeftCorner(2 * n, 2 * n), over.block(0, 2 * n, 2 * n, axes),
                         Eigen::MatrixXd::Zero(axes, 2 * n)};
    Eigen::MatrixXd held(n, 2 * n);
    held << -even(arm.attitude_stiffness), -even(arm.attitude_damping);
    result.transition += over.topRightCorner(2 * n, n) * held;
    result.way.leftCols(n) = way;
    return result;
}

} // namespace berth
