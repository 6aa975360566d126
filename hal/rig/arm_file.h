/* Arm files: TOML that describes an arm on a satellite, as a rig file names it or as `berth arm` prints it. */
#ifndef HAL_RIG_ARM_FILE_H
#define HAL_RIG_ARM_FILE_H

#include <string>
#include <vector>

#include "../../firmware/arm/arm_config.h"

namespace berth
{

struct arm_description {
    std::string name;
    std::string description;
    std::vector<std::string> joint_names;
    arm_config config = arm_default();
};

/* `origin` names the text in messages. Throws input_error with file, line and key. */
arm_description parse_arm(const std::string &text, const std::string &origin);

/* The name of a shipped arm, or a path. */
arm_description load_arm(const std::string &name_or_path);

/* Its text; throws input_error where it is a URDF file. */
std::string read_arm_file(const std::string &path);

/* The same as an arm file: parse_arm() of it gives the same values, bit for bit. `section`: what it is in, as in a
 * rig file; empty: a file of its own. */
std::string print_arm(const arm_description &arm, const std::string &section = "");

} // namespace berth

#endif
