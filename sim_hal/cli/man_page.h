/* Manual pages of the program, made from its commands. */
#ifndef SIM_HAL_CLI_MAN_PAGE_H
#define SIM_HAL_CLI_MAN_PAGE_H

#include "command_table.h"

namespace berth
{

/* berth(1): every command in a line. */
std::string man_page(const std::vector<command_entry> &table);

/* berth-run(1) and the like. */
std::string man_page(const command_entry &command);

} // namespace berth

#endif
