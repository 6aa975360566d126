/* The keys of an arm file, as tables for those who read and print it. */
#ifndef HAL_RIG_ARM_KEYS_H
#define HAL_RIG_ARM_KEYS_H

#include <array>
#include <cstddef>
#include <string_view>

#include "../../firmware/arm/arm_config.h"

namespace berth
{

/* A key of a section: so many numbers at this place of the section's struct. */
struct number_key {
    std::string_view name;
    std::size_t offset;
    std::size_t count;
    std::string_view meaning;
};

constexpr number_key key_of(std::string_view name, std::size_t offset, std::size_t bytes, std::string_view meaning)
{
    return {name, offset, bytes / sizeof(double), meaning};
}

#define KEY(type, member, meaning) key_of(#member, offsetof(type, member), sizeof(type::member), meaning)

inline constexpr std::array body_keys = {
    KEY(arm_body, mass_kg, "of the body"),
    KEY(arm_body, centre_m, "centre of mass, in the body's frame"),
    KEY(arm_body, inertia_kg_m2, "xx, xy, xz, yy, yz, zz about the centre"),
};
inline constexpr std::array frame_keys = {
    KEY(arm_frame, origin_m, "in the body before"),
    KEY(arm_frame, axes, "rows of the rotation; or rpy_rad = [roll, pitch, yaw] as in URDF"),
};
inline constexpr std::array joint_keys = {
    KEY(arm_joint, axis, "in the joint's frame"),
    KEY(arm_joint, stiffness_N_m_per_rad, "of the spring between motor and link"),
    KEY(arm_joint, damping_N_m_s_per_rad, "of the same spring"),
    KEY(arm_joint, rotor_inertia_kg_m2, "of the motor itself"),
    KEY(arm_joint, gear_ratio, "turns of the motor to one of the joint"),
    KEY(arm_joint, servo_frequency_Hz, "of the motor's position servo, the motor alone"),
    KEY(arm_joint, servo_damping_ratio, "of the motor's position servo, the motor alone"),
    KEY(arm_joint, torque_limit_N_m, "of the motor, behind the gear"),
    KEY(arm_joint, rate_limit_rad_per_s, "of commands"),
    KEY(arm_joint, acceleration_limit_rad_per_s2, "of commands"),
    KEY(arm_joint, angle_min_rad, "smallest angle of the joint"),
    KEY(arm_joint, angle_max_rad, "largest angle of the joint"),
    KEY(arm_joint, initial_rad, "angle at the start"),
};
inline constexpr std::array attitude_keys = {
    KEY(attitude_config, stiffness_N_m_per_rad, "of the attitude control with a wheel"),
    KEY(attitude_config, damping_N_m_s_per_rad, "of the attitude control with a wheel"),
    KEY(attitude_config, torque_limit_N_m, "of the wheel, or of a thruster's pulse"),
    KEY(attitude_config, momentum_limit_N_m_s, "of the wheel"),
    KEY(attitude_config, deadband_rad, "of the thrusters: smaller errors are left alone"),
    KEY(attitude_config, rate_weight_s, "thrusters: the rate counts as so much error"),
    KEY(attitude_config, on_time_min_ms, "thrusters: of a pulse; in whole ticks, as many as it takes"),
};
#undef KEY

inline constexpr std::array kind_words = {std::string_view("none"), std::string_view("planar"),
                                          std::string_view("spatial")};
inline constexpr std::array integrator_words = {std::string_view("semi_implicit_euler"), std::string_view("rk4"),
                                                std::string_view("implicit_midpoint")};
inline constexpr std::array force_words = {std::string_view("held"), std::string_view("led")};
inline constexpr std::array actuator_words = {std::string_view("none"), std::string_view("wheel"),
                                              std::string_view("thrusters")};
static_assert(kind_words.size() == ARM_KIND_COUNT && integrator_words.size() == ARM_INTEGRATOR_COUNT &&
              force_words.size() == ARM_FORCE_COUNT && actuator_words.size() == ATTITUDE_ACTUATOR_COUNT);

} // namespace berth

#endif
