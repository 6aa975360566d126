/* Runs one of the Python scripts beside the program, with the Python of its environment. */
#ifndef SIM_HAL_CLI_PYTHON_SCRIPT_H
#define SIM_HAL_CLI_PYTHON_SCRIPT_H

#include <string>
#include <vector>

namespace berth
{

/* `name`: of a file in scripts/; `doing`: what a terminal shows meanwhile. Returns the script's exit code. Throws
 * input_error, with what to do, where the script or its Python is missing. */
int run_script(const std::string &name, const std::string &doing, const std::vector<std::string> &arguments);

} // namespace berth

#endif
