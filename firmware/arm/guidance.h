/* Leads an arm's motors as the operator wants it: the tool along a direction or a straight line by resolved rates
 * (Whitney 1969), or joint by joint. Kinematics of the commanded angles alone, the base where it is: what bends and
 * drifts is the dynamics' business, so guidance closes no loop.
 *
 * Near singular poses the rates are damped least squares (Nakamura and Hanafusa 1986): the tool falls behind there
 * and the joints stay slow; a line waits for it, so that it stops on a line that leads out of reach. Rate and acceleration limits slow all joints alike where they lead the tool together, so
 * that a line stays straight, and each by itself where they have orders of their own. */
#ifndef FIRMWARE_ARM_GUIDANCE_H
#define FIRMWARE_ARM_GUIDANCE_H

#include "dynamics.h"
#include "guidance_order.h"

namespace berth
{

template <class Space>
struct guidance {
    joint_vector motor_rad; /* commanded, now ... */
    joint_vector motor_rad_per_s;
    int32_t mode; /* enum arm_order_kind of the newest order: a joint's also stands for the other joints' */
    arm_order joints[ARM_JOINTS_MAX];
    placement_of<Space> home; /* of the tool in the base, for an operator's position of 0 */
    typename Space::vector line_from_m;
    typename Space::vector line_way_m;
    double line_speed_m_per_s;
    double line_done_m;
    double line_m_per_s;
    uint32_t active; /* set of enum guidance_limit */
};

/* At rest: nothing is wanted. */
template <class Space>
guidance<Space> guidance_at(const chain<Space> &chain, const joint_vector &motor_rad);

/* Takes a new order. */
template <class Space>
void guidance_take(guidance<Space> &guidance, const chain<Space> &chain, const arm_order &order,
                   const typename Space::vector &direction, double operator_position_m);

/* One tick: the motors' angles move on by what was commanded, and get their rates for the tick to come. `direction`:
 * in the base's axes; with it the operator's position and velocity, for ARM_ORDER_FOLLOW. */
template <class Space>
void guidance_step(guidance<Space> &guidance, const chain<Space> &chain, const arm_config &config, double period_s,
                   const typename Space::vector &direction, double operator_position_m,
                   double operator_velocity_m_per_s);

/* How well the tool can be led at these angles, from 0 (singular) on: the least pivot of J J^T, lengths by the arm's
 * reach. Below guidance_singular the rates are damped. */
template <class Space>
double guidance_dexterity(const chain<Space> &chain, const joint_vector &link_rad);
constexpr double guidance_singular = 2.5e-3; /* a twentieth of the reach, squared */

} // namespace berth

#endif
