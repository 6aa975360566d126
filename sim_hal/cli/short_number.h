/* A number for reading: six digits. */
#ifndef SIM_HAL_CLI_SHORT_NUMBER_H
#define SIM_HAL_CLI_SHORT_NUMBER_H

#include <cstdio>
#include <string>

namespace berth
{

inline std::string short_number(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

} // namespace berth

#endif
