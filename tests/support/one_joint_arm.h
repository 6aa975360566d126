/* The plainest arm: one joint about z on a held base, its tool a metre out. Masses and springs are the caller's. */
#ifndef TESTS_SUPPORT_ONE_JOINT_ARM_H
#define TESTS_SUPPORT_ONE_JOINT_ARM_H

#include <limits>

#include "firmware/arm/arm_config.h"

/* Its turn as a mass on a spring, of 1 Hz and damping ratio 0.05; SI units. */
namespace one_joint
{

inline constexpr double inertia = 200.0;
inline constexpr double stiffness = 7895.683520871486;
inline constexpr double damping = 125.66370614359172;

} // namespace one_joint

inline arm_config one_joint_arm()
{
    constexpr double unlimited = std::numeric_limits<double>::infinity();
    arm_config config = arm_default();
    config.kind = ARM_PLANAR;
    config.base_is_free = 0;
    config.joint_count = 1;
    arm_joint &joint = config.joints[0];
    joint.frame.axes[0] = joint.frame.axes[4] = joint.frame.axes[8] = 1.0;
    joint.axis[2] = 1.0;
    joint.gear_ratio = 1.0;
    joint.torque_limit_N_m = joint.rate_limit_rad_per_s = joint.acceleration_limit_rad_per_s2 = unlimited;
    joint.angle_min_rad = -unlimited;
    joint.angle_max_rad = unlimited;
    config.tool.origin_m[0] = 1.0;
    return config;
}

#endif
