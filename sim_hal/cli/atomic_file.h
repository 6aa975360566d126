/* A file that appears under its name when it is whole, or not at all. */
#ifndef SIM_HAL_CLI_ATOMIC_FILE_H
#define SIM_HAL_CLI_ATOMIC_FILE_H

#include <cstdio>
#include <string>
#include <string_view>

namespace berth
{

/* Throws input_error where the file cannot be written. */
class atomic_file
{
  public:
    explicit atomic_file(const std::string &path);
    atomic_file(const atomic_file &) = delete;
    atomic_file &operator=(const atomic_file &) = delete;
    ~atomic_file();

    void write(std::string_view text);
    void close();  /* it is whole, and not yet under its name */
    void finish(); /* closes it if it is not */

  private:
    [[noreturn]] void fail();

    std::string path_;
    std::string partial_;
    std::FILE *file_;
    bool has_appeared_ = false;
};

} // namespace berth

#endif
