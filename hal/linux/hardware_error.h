/* A bus, a line or a clock that does not do what it should: one line for a person. Ends the program with exit
 * code 3. */
#ifndef HAL_LINUX_HARDWARE_ERROR_H
#define HAL_LINUX_HARDWARE_ERROR_H

#include <cstring>
#include <stdexcept>
#include <string>

namespace berth
{

class hardware_error : public std::runtime_error
{
    using std::runtime_error::runtime_error;
};

/* "what: why; what to do" */
[[noreturn]] inline void fail_hardware(const std::string &what, int error, const std::string &remedy)
{
    throw hardware_error(what + " (" + std::strerror(error) + "); " + remedy);
}

} // namespace berth

#endif
