/* Overruns on the machine's own clock. Bounds are one-sided: a busy machine may only be later. */
#include <doctest/doctest.h>

#include "../../hal/linux/tick_clock.h"

namespace berth
{

namespace
{

void oversleep(std::int64_t duration_ns)
{
    const timespec duration = timespec_of(duration_ns);
    clock_nanosleep(CLOCK_MONOTONIC, 0, &duration, nullptr);
}

} // namespace

TEST_CASE("tick clock: an overrun skips whole periods, counts them and keeps the phase")
{
    constexpr std::int64_t period_ns = 2500000;
    tick_clock clock(period_ns);
    CHECK(clock.zero_ns() % period_ns == 0);
    std::int64_t late_ns = 0;
    std::int64_t next_index = 0;
    bool has_missed = false;
    for (int i = 0; i < 40; i++) {
        if (i % 10 == 9) {
            oversleep(3 * period_ns);
        }
        const hal_tick tick = clock.wait(&late_ns);
        CHECK(tick.index == next_index + tick.missed);
        CHECK(tick.scheduled_ns == tick.index * period_ns);
        CHECK(tick.woke_ns >= tick.scheduled_ns);
        CHECK(tick.woke_ns < tick.scheduled_ns + period_ns);
        CHECK(late_ns == tick.woke_ns - tick.scheduled_ns + tick.missed * period_ns);
        has_missed |= i % 10 == 9 && tick.missed >= 2;
        next_index = tick.index + 1;
    }
    CHECK(has_missed);
}

} // namespace berth
