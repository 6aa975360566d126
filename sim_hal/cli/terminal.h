/* Long lines on a terminal: they are broken at blanks, and what follows stands under the line's text. A pipe or a
 * file gets each line whole, as programs read them. */
#ifndef SIM_HAL_CLI_TERMINAL_H
#define SIM_HAL_CLI_TERMINAL_H

#include <cstdio>
#include <string>
#include <string_view>

namespace berth
{

/* In columns: COLUMNS if it is set, else what the terminal says; 0: no terminal, or one that does not say it. */
std::size_t terminal_width(int file_descriptor);

/* A line without its end. "  name   text" goes on under its text, other lines two columns further in. Rows of a
 * table, which have three or more columns, stay as they are. */
std::string wrapped(std::string_view line, std::size_t width);

/* While it lives, `stream` (stdout or stderr) wraps what is printed. Lines that begin with a carriage return show
 * progress and stay as they are. */
class wrapped_stream
{
  public:
    wrapped_stream(std::FILE *&stream, int file_descriptor);
    wrapped_stream(const wrapped_stream &) = delete;
    wrapped_stream &operator=(const wrapped_stream &) = delete;
    ~wrapped_stream();

  private:
    static ssize_t write(void *self, const char *text, std::size_t bytes);
    void take(std::string_view text);

    std::FILE *&stream_;
    std::FILE *plain_;
    std::FILE *wrapping_ = nullptr;
    std::size_t width_;
    std::string line_;
};

} // namespace berth

#endif
