/* What is wrong with a command line, and how it is written. */
#ifndef SIM_HAL_CLI_USAGE_ERROR_H
#define SIM_HAL_CLI_USAGE_ERROR_H

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace berth
{

/* `words`: those behind the program's name. Where nothing better is known, the parser's own words. */
std::string usage_error(const CLI::App &app, const CLI::ParseError &error, const std::vector<std::string> &words);

} // namespace berth

#endif
