#include "colour.h"

#include <unistd.h>

#include <cstdlib>
#include <string_view>

namespace berth
{

bool has_colours(std::FILE *stream)
{
    const char *const no_color = std::getenv("NO_COLOR");
    const char *const terminal = std::getenv("TERM");
    const bool is_wanted = no_color == nullptr || *no_color == '\0';
    const bool can = terminal != nullptr && std::string_view(terminal) != "dumb";
    /* Not fileno(): a stream that wraps its lines has none, see terminal.h. */
    return is_wanted && can && isatty(stream == stderr ? STDERR_FILENO : STDOUT_FILENO) == 1;
}

std::string coloured(std::FILE *stream, ink colour, const std::string &text)
{
    if (!has_colours(stream)) {
        return text;
    }
    return "\033[" + std::to_string(static_cast<int>(colour)) + "m" + text + "\033[0m";
}

} // namespace berth
