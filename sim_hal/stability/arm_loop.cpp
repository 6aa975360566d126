#include "arm_loop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iterator>

#include "../../firmware/arm/robot_frame.h"
#include "../../firmware/compensation/compensation.h"
#include "../../firmware/pi.h"
#include "../../hal/rig/beam.h"
#include "../../hal/rig/rig_file.h"
#include "../effects/active.h"
#include "../solver/balance.h"
#include "../solver/decompositions.h"
#include "arm_period.h"
#include "period_map.h"
#include "spectrum.h"

namespace berth
{

namespace
{

/* A free satellite has z = 1, several times and defective: rounding spreads them by the root of the precision, up to
 * 4e-5 rad/s with 7 joints at 8 kHz. So slow, whatever the period, a mode counts as free. */
constexpr double free_rad_per_s = two_pi * 1e-4;

std::vector<std::complex<double>> bound_eigenvalues(const Eigen::MatrixXd &loop, double period_s)
{
    const double free_spread = free_rad_per_s * period_s;
    Eigen::MatrixXd even = loop;
    balance(even);
    std::vector<std::complex<double>> bound;
    for (const std::complex<double> &z : eigenvalues(even)) {
        if (std::abs(z - 1.0) > free_spread) {
            bound.push_back(z);
        }
    }
    return bound;
}

/* Robot, object and sensor along one axis, and the setpoints on their way: what a period makes of them. */
struct axis_period {
    Eigen::MatrixXd transition;
    Eigen::VectorXd by_way;
    Eigen::RowVectorXd load; /* at the end of the dead time, by these states ... */
    double load_by_way;      /* ... and by the tool's way */
};

axis_period axis_of(const rig &rig)
{
    const period_map map(rig);
    refuse_too_many_states(map.layout().count);
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
    return {whole.bottomRightCorner(others, others), whole.col(0).tail(others), whole.row(1).tail(others) / by_force,
            (whole(1, 0) - stepped(1.0, 0.0, 0.0)) / by_force};
}

/* Rows of the robot's frame: x, and in the order of enum side_axis the others; as the arm's space has them. */
template <class Space>
Eigen::MatrixXd ways_of(const linear_arm &arm, const Eigen::VectorXd &direction)
{
    const typename Space::vector x = direction.normalized();
    const auto frame = robot_frame<Space>::with_x_along(x);
    Eigen::MatrixXd ways = Eigen::MatrixXd::Zero(1 + SIDE_AXIS_COUNT, arm.count());
    ways.row(0) = x.transpose() * arm.tool_way;
    if constexpr (Space::turns == 1) {
        ways.row(1 + SIDE_AXIS_Y) = frame.y.transpose() * arm.tool_way;
        ways.row(1 + SIDE_AXIS_RZ) = arm.tool_turn;
    } else {
        ways.middleRows(1 + SIDE_AXIS_Y, 2) = frame.axes.template rightCols<2>().transpose() * arm.tool_way;
        ways.middleRows(1 + SIDE_AXIS_RX, 3) = frame.axes.transpose() * arm.tool_turn;
    }
    return ways;
}

/* The axes along which the robot displays the tool, and on each a loop with its own object. */
struct shown_axes {
    std::vector<rig> rigs;
    Eigen::MatrixXd ways; /* of the tool, a row for each, by q */
};

shown_axes axes_of(const rig &rig, const linear_arm &arm, const Eigen::VectorXd &direction)
{
    const Eigen::MatrixXd ways =
        direction.size() == 2 ? ways_of<plane>(arm, direction) : ways_of<space>(arm, direction);
    shown_axes shown = {{rig}, ways.topRows(1)};
    for (Eigen::Index axis = 0; axis < SIDE_AXIS_COUNT; axis++) {
        if (rig.firmware.side_axes[axis].enabled != 0) {
            shown.rigs.push_back(rig_along(rig, static_cast<std::size_t>(axis)));
            shown.ways.conservativeResize(shown.ways.rows() + 1, Eigen::NoChange);
            shown.ways.bottomRows(1) = ways.row(1 + axis);
        }
    }
    return shown;
}

Eigen::VectorXd start_of(const arm_config &arm)
{
    Eigen::VectorXd pose_rad(arm.joint_count);
    for (Eigen::Index i = 0; i < arm.joint_count; i++) {
        pose_rad(i) = arm.joints[i].initial_rad;
    }
    return pose_rad;
}

/* Of the tool, as the arm's world has it. */
Eigen::VectorXd direction_of(const rig &rig)
{
    const manipulator_config &manipulator = rig.firmware.manipulator;
    const Eigen::Vector3d direction(manipulator.direction_x, manipulator.direction_y, manipulator.direction_z);
    return direction.head(rig.firmware.arm.kind == ARM_PLANAR ? 2 : 3);
}

/* exp(s T) of what is not free. */
std::vector<std::complex<double>> sampled(const linear_arm &arm, double period_s)
{
    std::vector<std::complex<double>> bound;
    for (const std::complex<double> &s : eigenvalues_of(arm)) {
        if (std::abs(s) <= free_rad_per_s) {
            continue;
        }
        bound.push_back(std::exp(s * period_s));
        if (s.imag() > 0.0) {
            bound.push_back(std::exp(std::conj(s) * period_s));
        }
    }
    return bound;
}

/* What a step makes of a mode, of which s h is given; Hairer & Wanner, Solving Ordinary Differential Equations II.
 */
double growth_of_rk4(std::complex<double> sh)
{
    return std::abs(1.0 + sh * (1.0 + sh / 2.0 * (1.0 + sh / 3.0 * (1.0 + sh / 4.0))));
}

/* v' = v - h (w^2 x + d v), x' = x + h v' */
double growth_of_semi_implicit(std::complex<double> sh)
{
    const double half_trace = 1.0 + sh.real() - 0.5 * std::norm(sh);
    const double determinant = 1.0 + 2.0 * sh.real();
    const std::complex<double> root = std::sqrt(std::complex<double>(half_trace * half_trace - determinant));
    return sh.imag() == 0.0 ? 0.0 : std::max(std::abs(half_trace + root), std::abs(half_trace - root));
}

} // namespace

Eigen::MatrixXd arm_loop_matrix(const rig &rig, const arm_config &config, const linear_arm &arm,
                                const Eigen::VectorXd &direction)
{
    if (compensation_is_on(&rig.firmware)) {
        throw input_error(rig.name +
                          ": compensation has a model of a manipulator of one degree of freedom; switch it "
                          "off to look at a whole arm");
    }
    const shown_axes shown = axes_of(rig, arm, direction);
    std::vector<axis_period> axes;
    std::transform(shown.rigs.begin(), shown.rigs.end(), std::back_inserter(axes), axis_of);
    const arm_period period = period_of(arm, config, shown.ways, config_period_s(&rig.firmware));
    const Eigen::Index states = period.transition.rows();
    const bool is_led = config.force == ARM_FORCE_LED;
    Eigen::Index size = states;
    for (const axis_period &axis : axes) {
        size += axis.transition.rows() + (is_led ? 1 : 0);
    }
    refuse_too_many_states(size);
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(size, size);
    result.topLeftCorner(states, states) = period.transition;
    Eigen::Index from = states;
    const double of_now = is_led ? 1.5 : 1.0;
    for (std::size_t i = 0; i < axes.size(); i++) {
        const axis_period &axis = axes[i];
        const auto column = static_cast<Eigen::Index>(i);
        const Eigen::Index count = axis.transition.rows();
        const Eigen::RowVectorXd load_by_arm = axis.load_by_way * period.way.row(column);
        result.topLeftCorner(states, states) -= of_now * period.by_load.col(column) * load_by_arm;
        result.block(0, from, states, count) = -of_now * period.by_load.col(column) * axis.load;
        result.block(from, 0, count, states) = axis.by_way * period.way.row(column);
        result.block(from, from, count, count) = axis.transition;
        from += count;
        if (is_led) { /* a state more: the load of the tick before */
            result.block(0, from, states, 1) = 0.5 * period.by_load.col(column);
            result.block(from, 0, 1, states) = load_by_arm;
            result.block(from, from - count, 1, count) = axis.load;
            from++;
        }
    }
    return result;
}

arm_loop_growth growth_of(const Eigen::MatrixXd &loop, double period_s)
{
    arm_loop_growth found = {0.0, 0.0, 0.0};
    for (const std::complex<double> &z : bound_eigenvalues(loop, period_s)) {
        if (std::abs(z) > found.spectral_radius) {
            found = {std::abs(z), std::log(std::abs(z)) / period_s, std::abs(std::arg(z)) / (two_pi * period_s)};
        }
    }
    return found;
}

std::vector<std::complex<double>> arm_loop_eigenvalues(const rig &rig)
{
    const arm_config &arm = rig.firmware.arm;
    return bound_eigenvalues(arm_loop_matrix(rig, arm, linearise(arm, start_of(arm)), direction_of(rig)),
                             config_period_s(&rig.firmware));
}

std::vector<std::complex<double>> arm_eigenvalues(const rig &rig)
{
    const arm_config &arm = rig.firmware.arm;
    return sampled(linearise(arm, start_of(arm)), config_period_s(&rig.firmware));
}

std::vector<std::complex<double>> arm_with_object_eigenvalues(const rig &rig)
{
    const arm_config &config = rig.firmware.arm;
    linear_arm arm = linearise(config, start_of(config));
    const shown_axes shown = axes_of(rig, arm, direction_of(rig));
    for (std::size_t i = 0; i < shown.rigs.size(); i++) {
        Eigen::RowVectorXd way = Eigen::RowVectorXd::Zero(arm.count());
        way.head(shown.ways.cols()) = shown.ways.row(static_cast<Eigen::Index>(i));
        arm = with_object(arm, way, object_modes(shown.rigs[i].object));
    }
    return sampled(arm, config_period_s(&rig.firmware));
}

void refuse_unstable_steps(const rig &rig)
{
    constexpr double clearly = 1.05; /* a tick: far beyond what damping between modes, left out here, could hold */
    const arm_config &arm = rig.firmware.arm;
    if (arm.kind == ARM_NONE || arm.integrator == ARM_IMPLICIT_MIDPOINT) {
        return;
    }
    const double period_s = config_period_s(&rig.firmware);
    for (const std::complex<double> &s : eigenvalues_of(linearise(arm, start_of(arm)))) {
        const std::complex<double> step = s * period_s;
        if ((arm.integrator == ARM_RK4 ? growth_of_rk4(step) : growth_of_semi_implicit(step)) > clearly) {
            std::array<char, 300> text{};
            std::snprintf(
                text.data(), text.size(),
                "manipulator.arm: a mode of %.4g rad/s is too fast for integrator = \"%s\" in steps of %g ms: "
                "they blow up by themselves; take \"implicit_midpoint\", a softer joint or a shorter period",
                std::abs(s), arm.integrator == ARM_RK4 ? "rk4" : "semi_implicit_euler", 1e3 * period_s);
            throw input_error(text.data());
        }
    }
}

void refuse_arm(const rig &rig)
{
    if (rig.firmware.arm.kind != ARM_NONE) {
        const std::string effects = effect_keys_of(rig, is_beyond_small_motion);
        throw input_error(rig.name +
                          ": manipulator.arm: this reckons with a manipulator of one degree of freedom; run, eigen, "
                          "limits, map, reduce and accuracy look at the whole arm" +
                          (effects.empty() ? "" : ", the last five for small motions, without " + effects) +
                          ". Leave the arm out to look at its reduction");
    }
}

rig with_reduced(const rig &rig, const arm_mode &mode)
{
    berth::rig reduced = rig;
    reduced.firmware.arm.kind = ARM_NONE;
    for (side_axis_config &axis : reduced.firmware.side_axes) {
        axis.enabled = 0;
    }
    manipulator_config &manipulator = reduced.firmware.manipulator;
    manipulator.mass_kg = mode.mass_kg;
    manipulator.damping_N_s_per_m = mode.damping_N_s_per_m;
    manipulator.stiffness_N_per_m = mode.stiffness_N_per_m;
    return reduced;
}

} // namespace berth
