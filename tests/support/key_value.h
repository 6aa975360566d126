/* A key of a rig file with its value, for a rig's overrides: "object.mass_kg=100", exactly. */
#ifndef TESTS_SUPPORT_KEY_VALUE_H
#define TESTS_SUPPORT_KEY_VALUE_H

#include <cstdio>
#include <string>

namespace berth
{

inline std::string set(const char *key, double value)
{
    char text[80];
    std::snprintf(text, sizeof text, "%s=%.17g", key, value);
    return text;
}

} // namespace berth

#endif
