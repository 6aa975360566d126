/* The clock of a CAN controller that stamps frames itself: it starts anywhere and runs by its own crystal. Each
 * frame has the kernel's stamp as well, which is later by an interrupt's delay, never earlier: the least difference
 * seen says how the two clocks lie. */
#ifndef HAL_LINUX_HARDWARE_CLOCK_H
#define HAL_LINUX_HARDWARE_CLOCK_H

#include <algorithm>
#include <cstdint>

namespace berth
{

class hardware_clock
{
  public:
    /* When the frame was on the bus, by the clock of `software_ns`; never later than that. */
    std::int64_t software_time_ns(std::int64_t hardware_ns, std::int64_t software_ns)
    {
        const std::int64_t difference_ns = software_ns - hardware_ns;
        const std::int64_t passed_ns = hardware_ns - last_ns_;
        const bool is_new = !has_started_ || passed_ns < 0 || difference_ns - least_ns_ > delay_max_ns;
        least_ns_ =
            is_new ? difference_ns : std::min(difference_ns, least_ns_ + passed_ns / 1000 * drift_max_ppm / 1000);
        last_ns_ = hardware_ns;
        has_started_ = true;
        return hardware_ns + least_ns_;
    }

  private:
    static constexpr std::int64_t drift_max_ppm = 200;      /* of two crystals */
    static constexpr std::int64_t delay_max_ns = 100000000; /* more is a clock that was set anew */

    bool has_started_ = false;
    std::int64_t least_ns_ = 0;
    std::int64_t last_ns_ = 0;
};

} // namespace berth

#endif
