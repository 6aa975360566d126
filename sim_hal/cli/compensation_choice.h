/* `--with NAME`: the compensation units by name, at the settings that a rig file has if it says nothing else. */
#ifndef SIM_HAL_CLI_COMPENSATION_CHOICE_H
#define SIM_HAL_CLI_COMPENSATION_CHOICE_H

#include <string>
#include <vector>

namespace berth
{

/* "NAME, NAME, ..." */
std::string compensation_names();

bool is_compensation(const std::string &name);

/* "prediction is a compensation and no rig: ...", where a rig has to stand. */
std::string compensation_for_rig(const std::string &name);

/* As settings of rig keys. Throws input_error for an unknown name. */
std::vector<std::string> compensation_settings(const std::vector<std::string> &names);

} // namespace berth

#endif
