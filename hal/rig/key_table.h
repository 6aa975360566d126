/* The rows of the key table. */
#ifndef HAL_RIG_KEY_TABLE_H
#define HAL_RIG_KEY_TABLE_H

#include "keys.h"

namespace berth
{

std::vector<rig_key> make_keys();

} // namespace berth

#endif
