/* The arguments of `berth map` as a map. */
#ifndef SIM_HAL_CLI_MAP_REQUEST_H
#define SIM_HAL_CLI_MAP_REQUEST_H

#include "../stability/stability_map.h"
#include "commands.h"

namespace berth
{

/* The paper's robot is an ideal transmitter up to here: the wall on the maps. */
constexpr double wall_Hz = 5.0;

/* Runs instead of eigenvalues: asked for, or there are none. */
bool is_measured(const map_arguments &arguments, const rig &rig);

/* Throws input_error that names what is wrong. */
map_request make_map_request(const map_arguments &arguments, rig base);

/* The rig itself and those at the corners of the map that are possible: what an axis brings along, some of them
 * have.
 */
std::vector<rig> corners_of(const map_request &request);

/* Damped eigenfrequency of manipulator and object coupled without dead time, in Hz; 0 if it does not swing. */
double coupled_damped_frequency_Hz(const rig &rig);

/* "object.mass_kg", "omega/omega_M" ...: what a person reads at the axis. */
std::string axis_title(const map_axis &axis);

} // namespace berth

#endif
