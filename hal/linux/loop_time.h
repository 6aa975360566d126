/* The loop's time: CLOCK_MONOTONIC, counted from tick 0. Ticks lie at whole multiples of the period of that clock,
 * so programs on one machine agree on them without a word, and a step of the calendar's clock changes nothing.
 *
 * The kernel stamps frames by the calendar's clock (CLOCK_REALTIME), which may be stepped while they wait. */
#ifndef HAL_LINUX_LOOP_TIME_H
#define HAL_LINUX_LOOP_TIME_H

#include <algorithm>
#include <cstdint>
#include <ctime>

namespace berth
{

inline std::int64_t ns_of(const timespec &time)
{
    return std::int64_t{time.tv_sec} * 1000000000 + time.tv_nsec;
}

inline timespec timespec_of(std::int64_t time_ns)
{
    return {static_cast<time_t>(time_ns / 1000000000), static_cast<long>(time_ns % 1000000000)};
}

inline std::int64_t read_clock_ns(clockid_t clock)
{
    timespec now{};
    clock_gettime(clock, &now);
    return ns_of(now);
}

/* The first multiple of the period at or after `monotonic_ns`. */
inline std::int64_t next_tick_ns(std::int64_t monotonic_ns, std::int64_t period_ns)
{
    return (monotonic_ns + period_ns - 1) / period_ns * period_ns;
}

/* Turns the kernel's stamps into CLOCK_MONOTONIC. */
class stamp_clock
{
  public:
    /* Call before each reading of frames. */
    void update() { update(read_clock_ns(CLOCK_MONOTONIC), read_clock_ns(CLOCK_REALTIME)); }

    /* The same with two readings of one instant. */
    void update(std::int64_t monotonic_ns, std::int64_t realtime_ns)
    {
        last_reading_ns_ = now_ns_;
        now_ns_ = monotonic_ns;
        const std::int64_t offset_ns = realtime_ns - monotonic_ns;
        was_stepped_ = offset_ns - offset_ns_ > step_ns || offset_ns_ - offset_ns > step_ns;
        old_offset_ns_ = offset_ns_;
        offset_ns_ = offset_ns;
    }

    /* Where the clock was stepped since the reading before, a frame may carry either clock's stamp: the one by which
     * it came since then is right. */
    std::int64_t monotonic_ns(std::int64_t realtime_ns) const
    {
        const std::int64_t by_new_ns = realtime_ns - offset_ns_;
        const std::int64_t by_old_ns = realtime_ns - old_offset_ns_;
        const bool is_old =
            was_stepped_ && !came_since_last_reading(by_new_ns) && came_since_last_reading(by_old_ns);
        return std::min(is_old ? by_old_ns : by_new_ns, now_ns_);
    }

  private:
    static constexpr std::int64_t step_ns = 1000000;     /* slewing moves it by at most 0.5 us a ms */
    static constexpr std::int64_t tolerance_ns = 100000; /* between the two readings of update() */

    bool came_since_last_reading(std::int64_t time_ns) const
    {
        return time_ns <= now_ns_ + tolerance_ns && time_ns >= last_reading_ns_ - tolerance_ns;
    }

    std::int64_t now_ns_ = 0;
    std::int64_t last_reading_ns_ = 0;
    bool was_stepped_ = false;
    std::int64_t offset_ns_ = 0;
    std::int64_t old_offset_ns_ = 0;
};

} // namespace berth

#endif
