/* What a double can be and a setting must not. */
#ifndef TESTS_UNIT_NOT_FINITE_H
#define TESTS_UNIT_NOT_FINITE_H

#include <limits>

inline constexpr double infinity = std::numeric_limits<double>::infinity();
inline constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

#endif
