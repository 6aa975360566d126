/* Rig files to begin with: an object, a sensor and a robot, each key with what it means. */
#ifndef SIM_HAL_CLI_RIG_TEMPLATE_H
#define SIM_HAL_CLI_RIG_TEMPLATE_H

#include <string>
#include <vector>

#include "../../hal/rig/robot_file.h"

namespace berth
{

/* The words of `berth init --object` and `--sensor`. */
std::vector<std::string> template_objects();
std::vector<std::string> template_sensors();

struct template_choice {
    std::string name; /* of the rig */
    std::string object = "gripped";
    std::string sensor = "one-axis";
    std::optional<robot_preset> robot; /* nothing: the robot of the reference case */
};

/* The text of a rig file that reads, validates against the schema and runs. */
std::string rig_template(const template_choice &choice);

} // namespace berth

#endif
