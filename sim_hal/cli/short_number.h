/* Numbers for reading. */
#ifndef SIM_HAL_CLI_SHORT_NUMBER_H
#define SIM_HAL_CLI_SHORT_NUMBER_H

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace berth
{

/* Six digits. */
inline std::string short_number(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
}

/* Four digits and no exponent, as a person writes a force: 30.37, 14790. */
inline std::string four_digits(double value)
{
    constexpr int digits = 4;
    constexpr double most = 1e7;
    constexpr double least = 1e-4;
    char text[32];
    const double size = std::abs(value);
    if (!(size >= least && size < most)) {
        std::snprintf(text, sizeof text, "%.*g", digits, value);
        return text;
    }
    std::snprintf(text, sizeof text, "%.*e", digits - 1, value);
    const double rounded = std::strtod(text, nullptr);
    const int decimals = std::max(0, digits - 1 - static_cast<int>(std::floor(std::log10(std::abs(rounded)))));
    std::snprintf(text, sizeof text, "%.*f", decimals, rounded);
    return text;
}

} // namespace berth

#endif
