/* What a person meant by a line that is no TOML, and how to write it. */
#ifndef HAL_RIG_TOML_REMEDY_H
#define HAL_RIG_TOML_REMEDY_H

#include <cstddef>
#include <string>
#include <string_view>

namespace berth
{

/* `line`: counted from 1; `problem`: as the parser says it. Empty: nothing is known. */
std::string toml_remedy(std::string_view text, std::size_t line, std::string_view problem);

/* How to write a number that is none: "17,5", "34 ms", "8'000". Empty: nothing is known. */
std::string number_remedy(std::string_view value);

} // namespace berth

#endif
