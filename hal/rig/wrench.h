/* [wrench] of a rig file: how the force sensor is mounted, and what it confuses.
 *
 *     [wrench]
 *     roll_rad = 0.0                        # the sensor's axes in the robot's frame: fixed-axis angles, as in URDF
 *     x_m = 0.1                             # the sensor's origin there, from the tool's point
 *     torque_noise_N_m = 0.05               # as sensor.noise_N
 *     crosstalk = [[1.0, 0.02, ...], ...]   # 6 x 6: what it shows = crosstalk * (force, torque) */
#ifndef HAL_RIG_WRENCH_H
#define HAL_RIG_WRENCH_H

#include <ostream>

#include "toml_file.h"
#include "wrench_matrix.h"

namespace berth
{

/* Throws input_error. */
void read_wrench(rig &rig, const toml::table &table, const std::string &origin);

/* Nothing where the rig has none. */
void print_wrench(const wrench_rig &wrench, std::ostream &text);

/* What is wrong with it; fills in what the firmware has to know. */
std::optional<rig_error> complete_wrench(rig &rig);

} // namespace berth

#endif
