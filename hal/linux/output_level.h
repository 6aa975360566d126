/* The level that an output line is known to have. */
#ifndef HAL_LINUX_OUTPUT_LEVEL_H
#define HAL_LINUX_OUTPUT_LEVEL_H

#include <cstdint>

namespace berth
{

class output_level
{
  public:
    /* Calls `write(level)`, which costs a system call, unless the line is known to have this level. A negative
     * result means that the write failed: the next call writes again. */
    template <typename Write>
    void set(std::uint8_t level, Write write)
    {
        if (!is_known_ || level != level_) {
            is_known_ = write(level) >= 0;
            level_ = level;
        }
    }

  private:
    std::uint8_t level_ = 0; /* outputs start at 0 */
    bool is_known_ = true;
};

} // namespace berth

#endif
