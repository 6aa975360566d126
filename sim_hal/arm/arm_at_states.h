/* Inertia, forces and accelerations of an arm at states that somebody gives: what other programs' results are
 * compared with. */
#ifndef SIM_HAL_ARM_ARM_AT_STATES_H
#define SIM_HAL_ARM_ARM_AT_STATES_H

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "../../firmware/arm/arm_config.h"

namespace berth
{

/* `states`: a list of objects with the keys (planar: 2 and 1 in place of 3; quaternion is "attitude" too)
 *     position_m [3], attitude [4], turn_rate_rad_per_s [3], velocity_m_per_s [3]  of the base; the last two in its
 * axes link_rad [n], link_rad_per_s [n], torque_N_m [n]                  of the joints, on the link side
 *     tool_torque_N_m [3], tool_force_N [3]                             on the tool, in the world's axes
 *     wheel_N_m_s [3]
 * all 0 where they are missing. For each, with velocities of the base first, angular before linear:
 *     inertia     matrix over base and joints
 *     bias        forces that keep all accelerations at 0: Coriolis and centrifugal ones, without gravity
 *                 and wrench on the tool, which `acceleration` has
 *     acceleration of base and joints, as rates of the velocities
 *     momentum    about the world's origin, in its axes: angular, linear
 *     kinetic_J
 *     tool        origin in the world; `jacobian` of its twist in the base's axes
 * Throws input_error. */
nlohmann::json arm_at_states(const arm_config &config, const nlohmann::json &states, const std::string &origin);

} // namespace berth

#endif
