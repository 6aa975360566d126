/* What is being done, for whoever waits at a terminal. */
#ifndef SIM_HAL_CLI_PROGRESS_LINE_H
#define SIM_HAL_CLI_PROGRESS_LINE_H

#include <cstdio>
#include <string>
#include <unistd.h>

namespace berth
{

/* One line of standard error, gone at the end. Nothing is shown where that is no terminal. */
class progress_line
{
  public:
    progress_line() : is_shown_(isatty(STDERR_FILENO) != 0) {}
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
    bool is_shown_;
};

} // namespace berth

#endif
