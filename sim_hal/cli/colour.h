/* Colours on a terminal: none in a pipe or a file, with TERM=dumb, or where NO_COLOR is set (https://no-color.org).
 */
#ifndef SIM_HAL_CLI_COLOUR_H
#define SIM_HAL_CLI_COLOUR_H

#include <cstdio>
#include <string>

namespace berth
{

enum class ink { red = 31, green = 32, yellow = 33 };

bool has_colours(std::FILE *stream);

/* The text as it is where the stream has no colours. */
std::string coloured(std::FILE *stream, ink colour, const std::string &text);

} // namespace berth

#endif
