#include "tick_clock.h"

#include <cerrno>

#include "hardware_error.h"

namespace berth
{

hal_tick tick_clock::wait(std::int64_t *late_ns)
{
    const std::int64_t wanted_ns = zero_ns_ + next_index_ * period_ns_;
    const timespec wanted = timespec_of(wanted_ns);
    int error = 0;
    do { /* the error is returned, and positive */
        error = clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wanted, nullptr);
    } while (error == EINTR);
    if (error != 0) {
        fail_hardware("the clock does not wait for a tick", error, "this kernel has no usable CLOCK_MONOTONIC");
    }
    const std::int64_t woke_ns = read_clock_ns(CLOCK_MONOTONIC);
    *late_ns = woke_ns - wanted_ns;
    const std::int64_t missed = *late_ns / period_ns_;
    const std::int64_t index = next_index_ + missed;
    next_index_ = index + 1;
    return {index, index * period_ns_, woke_ns - zero_ns_, static_cast<std::uint32_t>(missed), 0};
}

} // namespace berth
