/* Runs Python's part of berth: the scripts beside the program, and the package. */
#ifndef SIM_HAL_CLI_PYTHON_SCRIPT_H
#define SIM_HAL_CLI_PYTHON_SCRIPT_H

#include <string>
#include <vector>

namespace berth
{

/* `name`: of a file in scripts/; `doing`: what a terminal shows meanwhile. Returns the script's exit code. Throws
 * input_error, with what to do, where the script or its Python is missing. */
int run_script(const std::string &name, const std::string &doing, const std::vector<std::string> &arguments);

/* Goes on as a module of the Python package, in place of this program: with the Python of the repository's
 * environment, or python3. Throws input_error where the package is missing, with how to install it. */
[[noreturn]] void become_module(const std::string &module, const std::vector<std::string> &arguments);

} // namespace berth

#endif
