/* [[orders]] of a rig file: what the operator orders an arm to do, and when.
 *
 *     at_s = 2.0            after the release
 *     line_m = [0.3, 0.0]   with speed_m_per_s: the tool along a line in the base's axes
 *     joint = 2             with rate_rad_per_s, or with move_to_rad and perhaps rate_rad_per_s: from 1 on
 *     follow = true         the tool follows the profile again */
#ifndef HAL_RIG_ORDERS_H
#define HAL_RIG_ORDERS_H

#include <ostream>

#include "toml_file.h"

namespace berth
{

/* Throws input_error. */
void read_orders(rig &rig, const toml::node &node, const std::string &origin, key_places &places);

/* Under which the place of an order, counted from 1, stands among the places. */
std::string place_key_of_order(std::size_t number);

void print_orders(const rig &rig, std::ostream &text);

/* What is wrong with one of them: an arm that is not there, a joint or an angle that it does not have. */
std::optional<rig_error> check_orders(const rig &rig);

} // namespace berth

#endif
