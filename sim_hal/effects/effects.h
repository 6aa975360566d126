/* One function a file: each makes the description of its effect. */
#ifndef SIM_HAL_EFFECTS_EFFECTS_H
#define SIM_HAL_EFFECTS_EFFECTS_H

#include "effect.h"

namespace berth
{

effect robot_dead_time();
effect robot_dead_time_drift();
effect robot_gain();
effect robot_lag();
effect robot_resonance();
effect robot_velocity_limit();
effect robot_acceleration_limit();
effect robot_backlash();
effect robot_deadband();
effect robot_lost_commands();
effect robot_periodic_error();
effect manipulator_parameters();
effect manipulator_coulomb_friction();
effect manipulator_asymmetric_friction();
effect manipulator_cubic_stiffness();
effect manipulator_quadratic_stiffness();
effect manipulator_backlash();
effect manipulator_gravity_offset();
effect object_parameters();
effect object_cubic_stiffness();
effect object_quadratic_stiffness();
effect object_coulomb_friction();
effect object_backlash();
effect object_second_mode();
effect object_hysteresis();
effect object_stiffness_drift();
effect object_loss_of_contact();
effect object_impact_damping();
effect sensor_bias();
effect sensor_drift();
effect sensor_gain();
effect sensor_lag();
effect sensor_delay();
effect sensor_saturation();
effect sensor_quantisation();
effect sensor_dropouts();
effect sensor_spikes();
effect sensor_periodic_disturbance();
effect loop_lost_samples();
effect loop_clock_drift();

} // namespace berth

#endif
