/* A number in an option's text: decimal, whatever the machine's language. */
#ifndef SIM_HAL_CLI_NUMBER_H
#define SIM_HAL_CLI_NUMBER_H

#include <charconv>
#include <cstring>

namespace berth
{

/* The number that starts at `at`, after blanks and a plus; `end` is behind it, or `at` where there is none. */
template <typename T>
T number_at(const char *at, const char **end)
{
    T value{};
    const char *first = at + std::strspn(at, " ");
    first += *first == '+' ? 1 : 0;
    const auto [behind, error] = std::from_chars(first, at + std::strlen(at), value);
    *end = error == std::errc() ? behind : at;
    return value;
}

} // namespace berth

#endif
