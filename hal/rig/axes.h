/* [axis.y], [axis.rz] ... of a rig file: what the robot shows of an arm's tool beside the direction of the loop,
 * with the hardware that it meets there.
 *
 *     [axis.y]                              [axis.rz]
 *     mass_kg = 100                         inertia_kg_m2 = 40         # of the object, needed
 *     stiffness_N_per_m = 2000              stiffness_N_m_per_rad = 800
 *     robot_dead_time_ms = 20               robot_dead_time_ms = 20    # else robot.dead_time_ms */
#ifndef HAL_RIG_AXES_H
#define HAL_RIG_AXES_H

#include <ostream>

#include "toml_file.h"

namespace berth
{

/* Throws input_error. */
void read_axis(rig &rig, const std::string &name, const toml::node &node, const std::string &origin);

/* The axes show the dead time of the robot, whatever their sections say: it is another robot's. */
void follow_dead_time(rig &rig);

/* Another dead time of the robot, and as much more or less of its further axes. */
void move_dead_time(rig &rig, double dead_time_ms);

void print_axes(const rig &rig, std::ostream &text);

/* What is wrong with them; fills in what the firmware has to know. */
std::optional<rig_error> complete_and_check_axes(rig &rig);

} // namespace berth

#endif
