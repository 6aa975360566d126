/* Completion of the program's commands in shells. */
#ifndef SIM_HAL_CLI_COMPLETION_H
#define SIM_HAL_CLI_COMPLETION_H

#include "command_table.h"

namespace berth
{

std::vector<std::string> shells(); /* "bash", "zsh", "fish" */

/* A script for the shell to source. */
std::string completion(const std::string &shell, const std::vector<command_entry> &table);

} // namespace berth

#endif
