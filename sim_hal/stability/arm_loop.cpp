#include "arm_loop.h"

#include <cmath>
#include <Eigen/Dense>
#include <unsupported/Eigen/MatrixFunctions>

#include "../../firmware/compensation/compensation.h"
#include "../../hal/rig/rig_file.h"
#include "../solver/balance.h"
#include "period_map.h"

namespace berth
{

namespace
{

constexpr double two_pi = 6.28318530717958647692;

/* The arm over a period with the force held: states q, q' in even scales. */
struct arm_period {
    Eigen::MatrixXd transition;
    Eigen::VectorXd by_force; /* of 1 N along the direction */
    Eigen::RowVectorXd way;   /* of the tool along the direction, by the states */
};

arm_period period_of(const linear_arm &arm, const Eigen::VectorXd &direction, double period_s)
{
    const Eigen::Index n = arm.count();
    const Eigen::VectorXd scale = arm.inertia.diagonal().cwiseSqrt().cwiseInverse();
    const auto even = [&](const Eigen::MatrixXd &matrix) {
        return Eigen::MatrixXd(scale.asDiagonal() * matrix * scale.asDiagonal());
    };
    const Eigen::RowVectorXd way = (direction.normalized().transpose() * arm.tool_way) * scale.asDiagonal();
    const Eigen::LLT<Eigen::MatrixXd> inertia(even(arm.inertia));
    Eigen::MatrixXd rates = Eigen::MatrixXd::Zero(2 * n + 1, 2 * n + 1);
    rates.block(0, n, n, n).setIdentity();
    rates.block(n, 0, n, n) = -inertia.solve(even(arm.stiffness));
    rates.block(n, n, n, n) = -inertia.solve(even(arm.damping));
    rates.block(n, 2 * n, n, 1) = inertia.solve(way.transpose());
    const Eigen::MatrixXd over = (rates * period_s).exp();
    arm_period result = {over.topLeftCorner(2 * n, 2 * n), over.topRightCorner(2 * n, 1),
                         Eigen::RowVectorXd::Zero(2 * n)};
    result.way.head(n) = way;
    return result;
}

std::vector<std::complex<double>> bound_eigenvalues(const Eigen::MatrixXd &loop)
{
    /* A free satellite has z = 1, several times and defective: rounding spreads them by the root of the precision.
     */
    constexpr double free_spread = 1e-4;
    Eigen::MatrixXd even = loop;
    balance(even);
    std::vector<std::complex<double>> bound;
    for (const std::complex<double> &z : even.eigenvalues()) {
        if (std::abs(z - 1.0) > free_spread) {
            bound.push_back(z);
        }
    }
    return bound;
}

} // namespace

Eigen::MatrixXd arm_loop_matrix(const rig &rig, const linear_arm &arm, const Eigen::VectorXd &direction)
{
    if (compensation_is_on(&rig.firmware)) {
        throw input_error(rig.name +
                          ": compensation has a model of a manipulator of one degree of freedom; switch it "
                          "off to look at a whole arm");
    }
    const period_map map(rig);
    const Eigen::MatrixXd whole = map.matrix();
    const Eigen::Index others = whole.rows() - 2;
    /* What the manipulator of one degree of freedom does by itself; the rest of its rows is the force. */
    app_config reduced = rig.firmware;
    reduced.arm.kind = ARM_NONE;
    manipulator alone;
    manipulator_start(&alone, &reduced);
    const operator_command rest{};
    const auto stepped = [&](double position_m, double velocity_m_per_s, double force_N) {
        alone.position_m = position_m;
        alone.velocity_m_per_s = velocity_m_per_s;
        manipulator_step(&alone, &rest, force_N);
        return alone.velocity_m_per_s;
    };
    const double by_force = stepped(0.0, 0.0, 1.0);
    const double force_by_position = (whole(1, 0) - stepped(1.0, 0.0, 0.0)) / by_force;
    const Eigen::RowVectorXd force_by_others = whole.row(1).tail(others) / by_force;

    const arm_period period = period_of(arm, direction, map.period_s());
    const Eigen::Index states = period.transition.rows();
    Eigen::MatrixXd result(states + others, states + others);
    result.topLeftCorner(states, states) = period.transition - period.by_force * (force_by_position * period.way);
    result.topRightCorner(states, others) = -period.by_force * force_by_others;
    result.bottomLeftCorner(others, states) = whole.col(0).tail(others) * period.way;
    result.bottomRightCorner(others, others) = whole.bottomRightCorner(others, others);
    return result;
}

arm_loop_growth growth_of(const Eigen::MatrixXd &loop, double period_s)
{
    arm_loop_growth found = {0.0, 0.0, 0.0};
    for (const std::complex<double> &z : bound_eigenvalues(loop)) {
        if (std::abs(z) > found.spectral_radius) {
            found = {std::abs(z), std::log(std::abs(z)) / period_s, std::abs(std::arg(z)) / (two_pi * period_s)};
        }
    }
    return found;
}

std::vector<std::complex<double>> arm_loop_eigenvalues(const rig &rig)
{
    const arm_config &arm = rig.firmware.arm;
    const manipulator_config &manipulator = rig.firmware.manipulator;
    Eigen::VectorXd pose_rad(arm.joint_count);
    for (Eigen::Index i = 0; i < arm.joint_count; i++) {
        pose_rad(i) = arm.joints[i].initial_rad;
    }
    const Eigen::Vector3d direction(manipulator.direction_x, manipulator.direction_y, manipulator.direction_z);
    return bound_eigenvalues(
        arm_loop_matrix(rig, linearise(arm, pose_rad), direction.head(arm.kind == ARM_PLANAR ? 2 : 3)));
}

void refuse_arm(const rig &rig)
{
    if (rig.firmware.arm.kind != ARM_NONE) {
        throw input_error(
            rig.name + ": manipulator.arm: this reckons with a manipulator of one degree of freedom; run, eigen, "
                       "map, reduce and accuracy look at the whole arm. Leave the arm out to look at its reduction");
    }
}

rig with_reduced(const rig &rig, const arm_mode &mode)
{
    berth::rig reduced = rig;
    reduced.firmware.arm.kind = ARM_NONE;
    manipulator_config &manipulator = reduced.firmware.manipulator;
    manipulator.mass_kg = mode.mass_kg;
    manipulator.damping_N_s_per_m = mode.damping_N_s_per_m;
    manipulator.stiffness_N_per_m = mode.stiffness_N_per_m;
    return reduced;
}

} // namespace berth
