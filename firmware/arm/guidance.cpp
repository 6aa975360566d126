#include "guidance.h"

#include <algorithm>
#include <cmath>

#include "factors.h"

extern "C" {
const char *const guidance_limit_names[GUIDANCE_LIMIT_COUNT] = {"rate", "acceleration", "angle", "singular"};
static_assert(GUIDANCE_SINGULAR == 1 << (GUIDANCE_LIMIT_COUNT - 1), "every limit has a name");
}

namespace berth
{

namespace
{

/* By which a tool that is off its line is brought back: slow against every loop, and well within the rates. */
constexpr double gain_per_s = 2.0;
/* A line's speed is reached, and left, within this time. */
constexpr double ramp_s = 1.0;
/* A line waits for a tool that is farther behind, of the reach: where it cannot be followed, a point that went on
 * would pull the tool off it sideways. */
constexpr double lead_max = 0.005;
/* A move to the end of the range asks for the very rate that may be: less than this apart they are the same. */
constexpr double rounding_rad_per_s = 1e-12;

/* The tool's ways that are led: where it is, and, by arms with enough joints, how it is turned. Linear rows by the
 * reach, so that all is in rad. */
template <class Space>
struct task {
    static constexpr int size = motion_of<Space>::size;
    using vector = Eigen::Matrix<double, size, 1>;
    using square = Eigen::Matrix<double, size, size>;
    using jacobian = Eigen::Matrix<double, size, ARM_JOINTS_MAX>;

    jacobian rows;
    double reach_m;
    bool is_turning;
};

template <class Space>
double reach_of(const chain<Space> &chain)
{
    double reach_m = std::sqrt(chain.tool.origin_m.squaredNorm());
    for (int i = 1; i < chain.joint_count; i++) {
        reach_m += std::sqrt(chain.joints[i].placement.origin_m.squaredNorm());
    }
    return std::max(reach_m, 1e-3);
}

template <class Space>
task<Space> task_at(const chain<Space> &chain, const chain_pose<Space> &pose)
{
    task<Space> led = {jacobian_of(chain, pose).joints, reach_of(chain),
                       chain.joint_count >= motion_of<Space>::size};
    led.rows.template bottomRows<Space::dimension>() /= led.reach_m;
    if (!led.is_turning) {
        led.rows.template topRows<Space::turns>().setZero();
    }
    return led;
}

/* J J^T; a way that is not led gets a 1, so that it neither counts nor stops the solution. */
template <class Space>
typename task<Space>::square gram_of(const task<Space> &led)
{
    typename task<Space>::square gram = led.rows * led.rows.transpose();
    for (int i = 0; i < Space::turns && !led.is_turning; i++) {
        gram(i, i) = 1.0;
    }
    return gram;
}

/* Small turn that leads from one attitude to the other, in the axes both are given in. */
template <class Space>
typename Space::angular turn_to(const typename Space::rotation &from, const typename Space::rotation &to)
{
    if constexpr (Space::turns == 1) {
        return typename Space::angular(from(0, 0) * to(1, 0) - from(1, 0) * to(0, 0));
    } else {
        typename Space::angular turn = Space::angular::Zero();
        for (int i = 0; i < Space::dimension; i++) {
            turn += 0.5 * typename Space::vector(from.col(i)).cross(typename Space::vector(to.col(i)));
        }
        return turn;
    }
}

/* Joint rates with which the tool moves at `velocity` and towards `goal`. */
template <class Space>
joint_vector resolved_rates(guidance<Space> &guidance, const chain<Space> &chain, const chain_pose<Space> &pose,
                            const placement_of<Space> &goal, const typename Space::vector &velocity)
{
    const placement_of<Space> tool = tool_in_base(chain, pose);
    const task<Space> led = task_at(chain, pose);
    typename task<Space>::vector wanted;
    wanted.setZero();
    if (led.is_turning) {
        wanted.template head<Space::turns>() = gain_per_s * turn_to<Space>(tool.axes, goal.axes);
    }
    wanted.template tail<Space::dimension>() =
        (velocity + gain_per_s * (goal.origin_m - tool.origin_m)) / led.reach_m;
    typename task<Space>::square gram = gram_of(led);
    const double pivot = least_pivot<task<Space>::size>(gram);
    if (pivot < guidance_singular) {
        const double missing = 1.0 - pivot / guidance_singular;
        gram.diagonal().array() += guidance_singular * missing * missing;
        guidance.active |= GUIDANCE_SINGULAR;
    }
    return led.rows.transpose() * semidefinite_solution<task<Space>::size>(gram, wanted);
}

/* The line's point now, and how fast it goes; the tool is at `tool_m` along the line. */
template <class Space>
double advance_line(guidance<Space> &guidance, double length_m, double tool_m, double reach_m, double period_s)
{
    const double speed = guidance.line_speed_m_per_s;
    const double ramp = speed / ramp_s;
    const double left_m = length_m - guidance.line_done_m;
    const double braking = std::sqrt(2.0 * ramp * std::max(left_m, 0.0));
    const double room_m = std::max(tool_m + lead_max * reach_m - guidance.line_done_m, 0.0);
    guidance.line_m_per_s =
        std::min({guidance.line_m_per_s + ramp * period_s, speed, braking, left_m / period_s, room_m / period_s});
    guidance.line_done_m += guidance.line_m_per_s * period_s;
    return guidance.line_m_per_s;
}

template <class Space>
joint_vector rates_along_line(guidance<Space> &guidance, const chain<Space> &chain, double period_s)
{
    const typename Space::vector &way = guidance.line_way_m;
    const double length_m = std::sqrt(way.squaredNorm());
    if (length_m <= 0.0) {
        return joint_vector::Zero();
    }
    placement_of<Space> goal = guidance.home;
    goal.origin_m = guidance.line_from_m + way * (guidance.line_done_m / length_m);
    const chain_pose<Space> pose = pose_of(chain, guidance.motor_rad);
    const double tool_m = way.dot(tool_in_base(chain, pose).origin_m - guidance.line_from_m) / length_m;
    const double speed = advance_line(guidance, length_m, tool_m, reach_of(chain), period_s);
    return resolved_rates<Space>(guidance, chain, pose, goal, way * (speed / length_m));
}

/* The fastest that a motor may go in the tick to come to be at rest after `distance_rad`, no harder than it may: n
 * more ticks brake, each by the same step, and the distance is T ((n + 1) rate - step n (n + 1) / 2). */
double rate_to_rest(double distance_rad, const arm_joint &joint, double period_s)
{
    const double step = joint.acceleration_limit_rad_per_s2 * period_s;
    if (!(distance_rad > 0.0 && std::isfinite(distance_rad) && std::isfinite(step))) {
        return distance_rad / period_s;
    }
    constexpr double whole_from = 4503599627370496.0; /* 2^52: a double has no fraction any more */
    const double exactly = 0.5 * (std::sqrt(1.0 + 8.0 * distance_rad / (step * period_s)) - 1.0);
    const double n = exactly < whole_from ? static_cast<double>(static_cast<int64_t>(exactly)) : exactly;
    return distance_rad / ((n + 1.0) * period_s) + 0.5 * n * step;
}

double rate_of_move(double motor_rad, const arm_order &order, const arm_joint &joint, double period_s)
{
    const double left_rad = order.angle_rad - motor_rad;
    double rate = rate_to_rest(std::abs(left_rad), joint, period_s);
    rate = std::min(rate, order.rate_rad_per_s > 0.0 ? order.rate_rad_per_s : rate);
    rate = std::min(rate, joint.rate_limit_rad_per_s);
    return left_rad < 0.0 ? -rate : rate;
}

template <class Space>
joint_vector rates_of_joints(const guidance<Space> &guidance, const arm_config &config, double period_s)
{
    joint_vector rates = joint_vector::Zero();
    for (int i = 0; i < config.joint_count; i++) {
        const arm_order &order = guidance.joints[i];
        rates(i) = order.kind == ARM_ORDER_JOINT_MOVE
                       ? rate_of_move(guidance.motor_rad(i), order, config.joints[i], period_s)
                       : order.rate_rad_per_s;
    }
    return rates;
}

/* No joint so fast that it could not be at rest at the end of its range. By itself, not by a factor for all: what
 * another joint needs must not keep this one from braking, and one that rests at its end holds no other back. */
template <class Space>
void hold_angles(guidance<Space> &guidance, const arm_config &config, double period_s, joint_vector &rates)
{
    for (int i = 0; i < static_cast<int>(config.joint_count); i++) {
        const arm_joint &joint = config.joints[i];
        const double motor_rad = guidance.motor_rad(i);
        const double allowed = std::clamp(rates(i), -rate_to_rest(motor_rad - joint.angle_min_rad, joint, period_s),
                                          rate_to_rest(joint.angle_max_rad - motor_rad, joint, period_s));
        if (std::abs(allowed - rates(i)) > rounding_rad_per_s) {
            guidance.active |= GUIDANCE_ANGLE;
        }
        rates(i) = allowed;
    }
}

/* By which each joint is slowed so that none of `sizes` exceeds its limit: where they lead the tool together all by
 * the same, so that a line stays straight; else each by itself, so that a move can count on its joint's braking. */
joint_vector shares_within(const joint_vector &sizes, const joint_vector &limits, int count, bool are_led_together)
{
    joint_vector shares = joint_vector::Ones();
    double least = 1.0;
    for (int i = 0; i < count; i++) {
        shares(i) = sizes(i) > limits(i) ? limits(i) / sizes(i) : 1.0;
        least = std::min(least, shares(i));
    }
    if (are_led_together) {
        shares.setConstant(least);
    }
    return shares;
}

/* No joint faster, no joint harder than it may; none beyond its angles. */
template <class Space>
void set_rates(guidance<Space> &guidance, const arm_config &config, joint_vector rates, double period_s)
{
    const auto count = static_cast<int>(config.joint_count);
    const bool are_led_together = guidance.mode != ARM_ORDER_JOINT_RATE && guidance.mode != ARM_ORDER_JOINT_MOVE;
    joint_vector fastest = joint_vector::Zero();
    joint_vector hardest = joint_vector::Zero();
    for (int i = 0; i < count; i++) {
        fastest(i) = config.joints[i].rate_limit_rad_per_s;
        hardest(i) = config.joints[i].acceleration_limit_rad_per_s2 * period_s;
    }
    const joint_vector slower = shares_within(rates.cwiseAbs(), fastest, count, are_led_together);
    rates = rates.cwiseProduct(slower);
    hold_angles(guidance, config, period_s, rates);
    const joint_vector change = rates - guidance.motor_rad_per_s;
    const joint_vector softer = shares_within(change.cwiseAbs(), hardest, count, are_led_together);
    guidance.active |= slower.minCoeff() < 1.0 ? GUIDANCE_RATE : 0;
    guidance.active |= softer.minCoeff() < 1.0 ? GUIDANCE_ACCELERATION : 0;
    guidance.motor_rad_per_s += softer.cwiseProduct(change);
    hold_angles(guidance, config, period_s, guidance.motor_rad_per_s);
}

} // namespace

template <class Space>
double guidance_dexterity(const chain<Space> &chain, const joint_vector &link_rad)
{
    return least_pivot<task<Space>::size>(gram_of(task_at(chain, pose_of(chain, link_rad))));
}

template <class Space>
guidance<Space> guidance_at(const chain<Space> &chain, const joint_vector &motor_rad)
{
    guidance<Space> still = {};
    still.motor_rad = motor_rad;
    still.motor_rad_per_s.setZero();
    still.home = tool_in_base(chain, pose_of(chain, motor_rad));
    still.line_from_m = still.home.origin_m;
    still.line_way_m.setZero();
    return still;
}

template <class Space>
void guidance_take(guidance<Space> &guidance, const chain<Space> &chain, const arm_order &order,
                   const typename Space::vector &direction, double operator_position_m)
{
    const placement_of<Space> tool = tool_in_base(chain, pose_of(chain, guidance.motor_rad));
    const bool was_joints = guidance.mode == ARM_ORDER_JOINT_RATE || guidance.mode == ARM_ORDER_JOINT_MOVE;
    switch (order.kind) {
    case ARM_ORDER_LINE:
        guidance.home.axes = tool.axes;
        guidance.line_from_m = tool.origin_m;
        guidance.line_way_m = Eigen::Map<const Eigen::Vector3d>(order.way_m).head<Space::dimension>();
        guidance.line_speed_m_per_s = order.speed_m_per_s;
        guidance.line_done_m = guidance.line_m_per_s = 0.0;
        break;
    case ARM_ORDER_FOLLOW:
        if (guidance.mode != ARM_ORDER_FOLLOW) {
            guidance.home = tool;
            guidance.home.origin_m -= direction * operator_position_m;
        }
        break;
    default:
        for (arm_order &joint : guidance.joints) {
            joint = was_joints ? joint : arm_order{ARM_ORDER_JOINT_RATE, 0, 0.0, 0.0, {}, 0.0};
        }
        guidance.joints[order.joint] = order;
        break;
    }
    guidance.mode = order.kind;
}

template <class Space>
void guidance_step(guidance<Space> &guidance, const chain<Space> &chain, const arm_config &config, double period_s,
                   const typename Space::vector &direction, double operator_position_m,
                   double operator_velocity_m_per_s)
{
    guidance.motor_rad += period_s * guidance.motor_rad_per_s;
    guidance.active = 0;
    joint_vector rates = joint_vector::Zero();
    switch (guidance.mode) {
    case ARM_ORDER_JOINT_RATE:
    case ARM_ORDER_JOINT_MOVE:
        rates = rates_of_joints(guidance, config, period_s);
        break;
    case ARM_ORDER_LINE:
        rates = rates_along_line(guidance, chain, period_s);
        break;
    default: {
        placement_of<Space> goal = guidance.home;
        goal.origin_m += direction * operator_position_m;
        rates = resolved_rates<Space>(guidance, chain, pose_of(chain, guidance.motor_rad), goal,
                                      direction * operator_velocity_m_per_s);
        break;
    }
    }
    set_rates(guidance, config, rates, period_s);
}

#define INSTANTIATE_GUIDANCE(Space)                                                                                 \
    template guidance<Space> guidance_at(const chain<Space> &, const joint_vector &);                               \
    template void guidance_take(guidance<Space> &, const chain<Space> &, const arm_order &, const Space::vector &,  \
                                double);                                                                            \
    template void guidance_step(guidance<Space> &, const chain<Space> &, const arm_config &, double,                \
                                const Space::vector &, double, double);                                             \
    template double guidance_dexterity(const chain<Space> &, const joint_vector &);
INSTANTIATE_GUIDANCE(plane)
INSTANTIATE_GUIDANCE(space)

} // namespace berth
