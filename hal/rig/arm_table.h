/* An arm as a table of TOML: an arm file, or [manipulator.arm] of a rig file. */
#ifndef HAL_RIG_ARM_TABLE_H
#define HAL_RIG_ARM_TABLE_H

#include "arm_file.h"
#include "toml_file.h"

namespace berth
{

/* Throws input_error with file, line and key. */
arm_description read_arm(const toml::table &table, const std::string &origin);

} // namespace berth

#endif
