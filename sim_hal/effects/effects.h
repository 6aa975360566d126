/* One function a file: each makes the description of its effect. */
#ifndef SIM_HAL_EFFECTS_EFFECTS_H
#define SIM_HAL_EFFECTS_EFFECTS_H

#include "effect.h"

/* All there are, in the order in which they are listed and, where several act on one signal, act. A new effect is a
 * file of its own and a line here. */
#define EFFECT_LIBRARY(EFFECT)                                                                                      \
    EFFECT(robot_dead_time)                                                                                         \
    EFFECT(robot_dead_time_drift)                                                                                   \
    EFFECT(robot_deadband)                                                                                          \
    EFFECT(robot_gain)                                                                                              \
    EFFECT(robot_lag)                                                                                               \
    EFFECT(robot_resonance)                                                                                         \
    EFFECT(robot_velocity_limit)                                                                                    \
    EFFECT(robot_acceleration_limit)                                                                                \
    EFFECT(robot_backlash)                                                                                          \
    EFFECT(robot_lost_commands)                                                                                     \
    EFFECT(robot_periodic_error)                                                                                    \
    EFFECT(manipulator_parameters)                                                                                  \
    EFFECT(manipulator_coulomb_friction)                                                                            \
    EFFECT(manipulator_asymmetric_friction)                                                                         \
    EFFECT(manipulator_stribeck_friction)                                                                           \
    EFFECT(manipulator_cubic_stiffness)                                                                             \
    EFFECT(manipulator_quadratic_stiffness)                                                                         \
    EFFECT(manipulator_backlash)                                                                                    \
    EFFECT(manipulator_gravity_offset)                                                                              \
    EFFECT(object_parameters)                                                                                       \
    EFFECT(object_cubic_stiffness)                                                                                  \
    EFFECT(object_quadratic_stiffness)                                                                              \
    EFFECT(object_coulomb_friction)                                                                                 \
    EFFECT(object_backlash)                                                                                         \
    EFFECT(object_second_mode)                                                                                      \
    EFFECT(object_hysteresis)                                                                                       \
    EFFECT(object_relaxation)                                                                                       \
    EFFECT(object_stiffness_drift)                                                                                  \
    EFFECT(object_loss_of_contact)                                                                                  \
    EFFECT(object_impact_damping)                                                                                   \
    EFFECT(sensor_bias)                                                                                             \
    EFFECT(sensor_drift)                                                                                            \
    EFFECT(sensor_gain)                                                                                             \
    EFFECT(sensor_curvature)                                                                                        \
    EFFECT(sensor_tool_inertia)                                                                                     \
    EFFECT(sensor_lag)                                                                                              \
    EFFECT(sensor_delay)                                                                                            \
    EFFECT(sensor_saturation)                                                                                       \
    EFFECT(sensor_quantisation)                                                                                     \
    EFFECT(sensor_dropouts)                                                                                         \
    EFFECT(sensor_spikes)                                                                                           \
    EFFECT(sensor_periodic_disturbance)                                                                             \
    EFFECT(loop_lost_samples)                                                                                       \
    EFFECT(loop_clock_drift)

namespace berth
{

#define DECLARE_EFFECT(name) effect name();
EFFECT_LIBRARY(DECLARE_EFFECT)
#undef DECLARE_EFFECT

} // namespace berth

#endif
