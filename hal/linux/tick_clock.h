/* Ticks at absolute times. After an overrun the phase is kept: whole periods are skipped and counted. */
#ifndef HAL_LINUX_TICK_CLOCK_H
#define HAL_LINUX_TICK_CLOCK_H

#include "../hal.h"
#include "loop_time.h"

namespace berth
{

class tick_clock
{
  public:
    /* The first tick comes with the next multiple of the period that leaves time to get ready. */
    explicit tick_clock(std::int64_t period_ns)
        : period_ns_(period_ns), zero_ns_(next_tick_ns(read_clock_ns(CLOCK_MONOTONIC) + period_ns, period_ns))
    {
    }

    std::int64_t zero_ns() const { return zero_ns_; } /* tick 0 by CLOCK_MONOTONIC */
    std::int64_t period_ns() const { return period_ns_; }

    /* Sleeps until the next tick; `late_ns` is how long after that instant the loop woke. Throws hardware_error. */
    hal_tick wait(std::int64_t *late_ns);

  private:
    std::int64_t period_ns_;
    std::int64_t zero_ns_;
    std::int64_t next_index_ = 0;
};

} // namespace berth

#endif
