/* A sentence with one or two numbers in it. */
#ifndef SIM_HAL_DIAGNOSIS_FORMATTED_H
#define SIM_HAL_DIAGNOSIS_FORMATTED_H

#include <cstdio>
#include <string>

namespace berth
{

/* `format`: of printf, for two numbers at most; 199 characters are kept. */
inline std::string formatted(const char *format, double a, double b = 0.0)
{
    char result[200];
    std::snprintf(result, sizeof result, format, a, b);
    return result;
}

} // namespace berth

#endif
