/* What is being done, for whoever waits at a terminal. */
#ifndef SIM_HAL_CLI_PROGRESS_LINE_H
#define SIM_HAL_CLI_PROGRESS_LINE_H

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <unistd.h>

namespace berth
{

/* One line of standard error, gone at the end. Nothing is shown where that is no terminal, or one that only prints.
 */
class progress_line
{
  public:
    progress_line() : is_shown_(isatty(STDERR_FILENO) != 0 && can_erase()) {}
    progress_line(const progress_line &) = delete;
    progress_line &operator=(const progress_line &) = delete;
    ~progress_line() { show(""); }
    void show(const std::string &what) const
    {
        if (is_shown_) {
            std::fprintf(stderr, "\r\033[K%s", what.c_str());
        }
    }

  private:
    static bool can_erase()
    {
        const char *const terminal = std::getenv("TERM");
        return terminal != nullptr && std::string_view(terminal) != "dumb";
    }

    bool is_shown_;
};

} // namespace berth

#endif
