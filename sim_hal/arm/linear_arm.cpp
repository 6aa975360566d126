#include "linear_arm.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <Eigen/Core>

#include "../../firmware/arm/dynamics.h"
#include "../../firmware/pi.h"
#include "../../hal/rig/rig_file.h"
#include "../solver/decompositions.h"
#include "../solver/factors.h"

namespace berth
{

namespace
{

/* Below this share of the tool's mobility a mode is not seen at the tool, nor a direction; rounding. */
constexpr double share_min = 1e-9;

/* Slower than this, nothing holds a mode: rounding of the eigenvalues. */
constexpr double held_min_Hz = 1e-4;

template <class Space>
linear_arm linearised(const arm_config &config, const Eigen::VectorXd &pose_rad)
{
    const chain<Space> chain = make_chain<Space>(config);
    const chain_state<Space> start = state_at_start<Space>(config);
    const Eigen::Index n = chain.joint_count;
    const Eigen::Index base = chain.base_is_free ? motion_of<Space>::size : 0;
    joint_vector links = joint_vector::Zero();
    links.head(n) = pose_rad;
    const chain_pose<Space> pose = pose_of(chain, links);
    const chain_inertia<Space> inertia = inertia_of_chain(chain, pose);
    const tool_jacobian<Space> jacobian = jacobian_of(chain, pose);

    const Eigen::Index count = base + 2 * n;
    linear_arm arm;
    arm.inertia = arm.damping = arm.stiffness = arm.attitude_damping = arm.attitude_stiffness =
        Eigen::MatrixXd::Zero(count, count);
    arm.inertia.block(base, base, n, n) = inertia.joints.topLeftCorner(n, n);
    if (base > 0) {
        arm.inertia.topLeftCorner(base, base) = inertia.base.matrix();
        arm.inertia.block(0, base, base, n) = inertia.coupling.leftCols(n);
        arm.inertia.block(base, 0, n, base) = inertia.coupling.leftCols(n).transpose();
        if (config.attitude.actuator == ATTITUDE_WHEEL) {
            for (int i = 0; i < Space::turns; i++) {
                arm.damping(i, i) = arm.attitude_damping(i, i) = config.attitude.damping_N_m_s_per_rad;
                arm.stiffness(i, i) = arm.attitude_stiffness(i, i) = config.attitude.stiffness_N_m_per_rad;
            }
        }
    }
    for (Eigen::Index i = 0; i < n; i++) {
        const chain_joint<Space> &joint = chain.joints[i];
        const Eigen::Index link = base + i;
        const Eigen::Index motor = link + n;
        arm.inertia(motor, motor) = joint.motor_inertia_kg_m2;
        const auto couple = [&](Eigen::MatrixXd &matrix, double between, double servo) {
            matrix(link, link) += between;
            matrix(motor, motor) += between + servo;
            matrix(link, motor) -= between;
            matrix(motor, link) -= between;
        };
        couple(arm.damping, joint.damping_N_m_s_per_rad, joint.servo_damping_N_m_s_per_rad);
        couple(arm.stiffness, joint.stiffness_N_m_per_rad, joint.servo_stiffness_N_m_per_rad);
    }
    const placement_of<Space> world = {Space::vector::Zero(), Space::axes_of(start.attitude())};
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(motion_of<Space>::size, count);
    if (base > 0) {
        all.leftCols(base) = jacobian.base;
    }
    all.middleCols(base, n) = jacobian.joints.leftCols(n);
    arm.tool_way = world.axes * all.bottomRows(Space::dimension);
    arm.tool_turn = all.topRows(Space::turns);
    if constexpr (Space::turns == 3) {
        arm.tool_turn = world.axes * arm.tool_turn;
    }
    return arm;
}

/* A torque that is held for T is late by T/2 in the mean: -K phi - D phi' then acts as -K phi - (D - K T/2) phi'
 * + (D T/2) phi''. Is that more than a hundredth of the damping, or of the satellite's own inertia? */
bool hold_matters(const arm_config &config, double period_s)
{
    constexpr double least_share = 0.01;
    const double *const inertia = config.base.inertia_kg_m2;
    const double turning_kg_m2 =
        config.kind == ARM_PLANAR ? inertia[5] : std::min({inertia[0], inertia[3], inertia[5]});
    const double late_s = 0.5 * period_s;
    const double damping = config.attitude.damping_N_m_s_per_rad;
    return config.attitude.stiffness_N_m_per_rad * late_s > least_share * damping ||
           damping * late_s > least_share * turning_kg_m2;
}

std::string held_wheel_text(const attitude_config &attitude)
{
    return "attitude.period_ticks: the wheel's torque is held for " + std::to_string(attitude.period_ticks) +
           (attitude.period_ticks == 1 ? " tick" : " ticks") +
           "; small motions take the wheel for a spring and a damper without that";
}

/* Scales in which rotations and ways of a large arm are of one size: the inverse roots of the inertia's diagonal. */
Eigen::MatrixXd scaling(const linear_arm &arm)
{
    return arm.inertia.diagonal().cwiseSqrt().cwiseInverse().asDiagonal();
}

} // namespace

std::vector<std::string> attitude_left_out(const arm_config &config)
{
    const attitude_config &attitude = config.attitude;
    if (config.kind == ARM_NONE || config.base_is_free == 0) {
        return {};
    }
    if (attitude.actuator == ATTITUDE_THRUSTERS) {
        return {"attitude.actuator: thrusters have no linearisation and are left out: the satellite is taken as not "
                "held"};
    }
    if (attitude.actuator == ATTITUDE_WHEEL && attitude.period_ticks > 1) {
        return {held_wheel_text(attitude)};
    }
    return {};
}

std::vector<std::string> attitude_left_out_without_ticks(const arm_config &config, double period_s)
{
    std::vector<std::string> told = attitude_left_out(config);
    if (told.empty() && config.base_is_free != 0 && config.attitude.actuator == ATTITUDE_WHEEL &&
        hold_matters(config, period_s)) {
        told.push_back(held_wheel_text(config.attitude));
    }
    return told;
}

linear_arm linearise(const arm_config &config, const Eigen::VectorXd &pose_rad)
{
    if (std::any_of(std::begin(config.gravity_m_per_s2), std::end(config.gravity_m_per_s2),
                    [](double part) { return part != 0.0; })) {
        throw input_error(
            "base.gravity_m_per_s2: small motions are about a rest, and gravity leaves the arm none at "
            "its start; look at what `berth run` measures, or leave gravity out");
    }
    return config.kind == ARM_PLANAR ? linearised<plane>(config, pose_rad) : linearised<space>(config, pose_rad);
}

linear_arm combined(const linear_arm &arm, const Eigen::MatrixXd &basis)
{
    return {basis.transpose() * arm.inertia * basis,
            basis.transpose() * arm.damping * basis,
            basis.transpose() * arm.stiffness * basis,
            basis.transpose() * arm.attitude_damping * basis,
            basis.transpose() * arm.attitude_stiffness * basis,
            arm.tool_turn * basis,
            arm.tool_way * basis};
}

Eigen::MatrixXd guided_basis(const linear_arm &arm, const Eigen::VectorXd &direction)
{
    const Eigen::Index dimension = direction.size();
    const Eigen::VectorXd along = direction.normalized();
    const Eigen::MatrixXd across =
        (Eigen::MatrixXd::Identity(dimension, dimension) - along * along.transpose()) * arm.tool_way;
    Eigen::MatrixXd held(across.rows() + (dimension == 3 ? 3 : 0), arm.count());
    held.topRows(across.rows()) = across;
    if (dimension == 3) {
        held.bottomRows(3) = arm.tool_turn;
    }
    const Eigen::MatrixXd scaled = scaling(arm);
    const Eigen::MatrixXd free = kernel(held * scaled, 1e-10);
    return scaled * orthonormal_basis(free).leftCols(free.cols());
}

linear_arm guided(const linear_arm &arm, const Eigen::VectorXd &direction)
{
    return combined(arm, guided_basis(arm, direction));
}

std::vector<arm_mode> modes_along(const linear_arm &arm, const Eigen::VectorXd &direction)
{
    return modes_along(arm, direction, arm);
}

std::vector<arm_mode> modes_along(const linear_arm &arm, const Eigen::VectorXd &direction, const linear_arm &free)
{
    const eigenpairs swings = generalised_eigenpairs(arm.stiffness, arm.inertia);
    const Eigen::RowVectorXd at_tool = direction.normalized().transpose() * arm.tool_way;
    const Eigen::VectorXd mobility = (at_tool * swings.vectors).array().square();
    const double all_ways = (free.tool_way * positive_solutions(free.inertia, free.tool_way.transpose())).trace();
    std::vector<arm_mode> modes;
    if (!(mobility.sum() > share_min * all_ways)) {
        return modes;
    }
    for (Eigen::Index i = 0; i < arm.count(); i++) {
        const double share = mobility(i) / mobility.sum();
        if (share < share_min) {
            continue;
        }
        const Eigen::VectorXd shape = swings.vectors.col(i);
        double w = std::sqrt(std::max(0.0, swings.values(i)));
        w = w < two_pi * held_min_Hz ? 0.0 : w;
        const double loss = shape.dot(arm.damping * shape);
        const double by_attitude = shape.dot(arm.attitude_stiffness * shape);
        modes.push_back({w / two_pi, w > 0.0 ? loss / (2.0 * w) : 0.0, share, w > 0.0 ? by_attitude / (w * w) : 0.0,
                         1.0 / mobility(i), loss / mobility(i), w * w / mobility(i)});
    }
    return modes;
}

arm_mode dominant_mode(const std::vector<arm_mode> &modes)
{
    const arm_mode *found = nullptr;
    for (const arm_mode &mode : modes) {
        const bool is_the_arms = mode.frequency_Hz > 0.0 && mode.attitude_share < 0.5;
        if (is_the_arms && (found == nullptr || mode.share > found->share)) {
            found = &mode;
        }
    }
    if (found == nullptr) {
        throw nothing_springy("at this pose no spring of the arm moves the tool along the direction; take another");
    }
    return *found;
}

std::vector<std::complex<double>> eigenvalues_of(const linear_arm &arm)
{
    const Eigen::Index n = arm.count();
    const Eigen::MatrixXd scaled = scaling(arm);
    const linear_arm even = combined(arm, scaled);
    Eigen::MatrixXd first_order = Eigen::MatrixXd::Zero(2 * n, 2 * n);
    first_order.topRightCorner(n, n).setIdentity();
    first_order.bottomLeftCorner(n, n) = -positive_solutions(even.inertia, even.stiffness);
    first_order.bottomRightCorner(n, n) = -positive_solutions(even.inertia, even.damping);
    std::vector<std::complex<double>> found;
    for (const std::complex<double> &s : eigenvalues(first_order)) {
        if (s.imag() >= 0.0) {
            found.push_back(s);
        }
    }
    std::sort(found.begin(), found.end(), [](auto a, auto b) { return std::abs(a) < std::abs(b); });
    return found;
}

Eigen::VectorXcd shape_of(const linear_arm &arm, std::complex<double> s)
{
    const Eigen::MatrixXd scaled = scaling(arm);
    const linear_arm even = combined(arm, scaled);
    const Eigen::MatrixXcd stiffness = s * s * even.inertia + s * even.damping + even.stiffness;
    return scaled * least_singular_vector(stiffness);
}

linear_arm arm_of(const manipulator_config &manipulator)
{
    const auto number = [](double value) { return Eigen::MatrixXd::Constant(1, 1, value); };
    return {number(manipulator.mass_kg),
            number(manipulator.damping_N_s_per_m),
            number(manipulator.stiffness_N_per_m),
            number(0.0),
            number(0.0),
            Eigen::MatrixXd(0, 1),
            number(1.0)};
}

linear_arm with_object(const linear_arm &arm, const Eigen::RowVectorXd &way, const std::vector<beam_mode> &modes)
{
    const auto further = static_cast<Eigen::Index>(modes.size()) - 1;
    const Eigen::Index count = arm.count() + further;
    Eigen::MatrixXd old = Eigen::MatrixXd::Zero(arm.count(), count); /* q by the new coordinates */
    old.leftCols(arm.count()).setIdentity();
    linear_arm both = combined(arm, old);
    Eigen::RowVectorXd moved(count);
    moved << way, Eigen::RowVectorXd::Constant(further, -1.0);
    for (std::size_t i = 0; i < modes.size(); i++) {
        if (i > 0) {
            moved = Eigen::RowVectorXd::Unit(count, arm.count() + static_cast<Eigen::Index>(i) - 1);
        }
        const Eigen::MatrixXd square = moved.transpose() * moved;
        both.inertia += modes[i].mass_kg * square;
        both.damping += modes[i].damping_N_s_per_m * square;
        both.stiffness += modes[i].stiffness_N_per_m * square;
    }
    return both;
}

} // namespace berth
