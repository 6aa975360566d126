/* Stamps by the calendar's clock, and the grid of ticks. */
#include <doctest/doctest.h>

#include "../../hal/linux/loop_time.h"

namespace berth
{

namespace
{

constexpr std::int64_t year_2026_ns = 1790000000000000000;
constexpr std::int64_t ms = 1000000;

/* Read once before, and now. */
stamp_clock clock_at(std::int64_t monotonic_ns, std::int64_t realtime_ns)
{
    stamp_clock clock;
    clock.update(monotonic_ns - 10 * ms, realtime_ns - 10 * ms);
    clock.update(monotonic_ns, realtime_ns);
    return clock;
}

} // namespace

TEST_CASE("stamps: a frame of 3 ms ago was stamped 3 ms ago")
{
    const stamp_clock clock = clock_at(5000 * ms, year_2026_ns);
    CHECK(clock.monotonic_ns(year_2026_ns - 3 * ms) == 4997 * ms);
    CHECK(clock.monotonic_ns(year_2026_ns) == 5000 * ms);
}

TEST_CASE("stamps: the calendar's clock may be stepped while a frame waits")
{
    for (const std::int64_t step_ns : {3600000 * ms, -3600000 * ms, 20 * ms, -20 * ms}) {
        CAPTURE(step_ns);
        stamp_clock clock = clock_at(5000 * ms, year_2026_ns);
        const std::int64_t stamped_before_ns = year_2026_ns + 1 * ms; /* received at 5001 ms */
        clock.update(5002 * ms, year_2026_ns + 2 * ms + step_ns);
        CHECK(clock.monotonic_ns(stamped_before_ns) == 5001 * ms);
        CHECK(clock.monotonic_ns(year_2026_ns + 2 * ms + step_ns - ms / 2) == 5002 * ms - ms / 2);
        clock.update(5004 * ms, year_2026_ns + 4 * ms + step_ns);
        CHECK(clock.monotonic_ns(year_2026_ns + 3 * ms + step_ns) == 5003 * ms);
    }
}

TEST_CASE("stamps: a frame that waited long is as old as it is, and none is of the future")
{
    const stamp_clock clock = clock_at(5000 * ms, year_2026_ns);
    CHECK(clock.monotonic_ns(year_2026_ns - 4000 * ms) == 1000 * ms);
    CHECK(clock.monotonic_ns(year_2026_ns + 1 * ms) == 5000 * ms);
}

TEST_CASE("ticks lie at whole multiples of the period")
{
    CHECK(next_tick_ns(0, 2500000) == 0);
    CHECK(next_tick_ns(1, 2500000) == 2500000);
    CHECK(next_tick_ns(2500000, 2500000) == 2500000);
    CHECK(next_tick_ns(2500001, 2500000) == 5000000);
}

} // namespace berth
