#include <doctest/doctest.h>

#include <string>

#include "firmware/missed_time.h"

namespace
{

/* 25 ms that refill in 10 s: at 400 Hz ten ticks at once, and one a second in the long run. */
missed_time budget_at_start(double rate_Hz = 400.0)
{
    app_config config = config_default();
    config.loop.rate_Hz = rate_Hz;
    config.loop.missed_time_budget_ms = 25.0;
    config.loop.missed_time_refill_s = 10.0;
    missed_time missed;
    missed_time_start(&missed, &config);
    return missed;
}

/* Ticks with one missed every so many; the number of those before the budget is used up, or -1. */
int missed_until_over(missed_time missed, int every_ticks, int count_max)
{
    for (int count = 1; count <= count_max; count++) {
        for (int tick = 1; tick < every_ticks; tick++) {
            missed_time_step(&missed, 0);
        }
        missed_time_step(&missed, 1);
        if (missed_time_is_over(&missed)) {
            return count;
        }
    }
    return -1;
}

} // namespace

TEST_CASE("missed_time: the budget is a time: how many ticks it is depends on the rate")
{
    const struct {
        double rate_Hz;
        std::uint32_t fits;
    } rows[] = {{400.0, 10}, {1000.0, 25}, {10000.0, 250}, {50.0, 1}};
    for (const auto &row : rows) {
        CAPTURE(row.rate_Hz);
        missed_time missed = budget_at_start(row.rate_Hz);
        missed_time_step(&missed, row.fits);
        CHECK_FALSE(missed_time_is_over(&missed));
        missed = budget_at_start(row.rate_Hz);
        missed_time_step(&missed, row.fits + 1);
        CHECK(missed_time_is_over(&missed));
    }
}

TEST_CASE("missed_time: single missed ticks use up the budget only if they come faster than it refills")
{
    CHECK(missed_until_over(budget_at_start(), 400, 20000) == -1); /* one a second, for five hours */
    const int faster = missed_until_over(budget_at_start(), 200, 1000);
    CHECK(faster > 15); /* each refills half of what it takes */
    CHECK(faster < 25);
    CHECK(missed_until_over(budget_at_start(), 1, 1000) == 11);
}

TEST_CASE("missed_time: the whole budget is there again after the time to refill, and not before")
{
    for (const int wait_ticks : {3600, 4000}) {
        CAPTURE(wait_ticks);
        missed_time missed = budget_at_start();
        missed_time_step(&missed, 10);
        REQUIRE_FALSE(missed_time_is_over(&missed));
        for (int tick = 0; tick < wait_ticks; tick++) {
            missed_time_step(&missed, 0);
        }
        missed_time_step(&missed, 10);
        CHECK((missed_time_is_over(&missed) != 0) == (wait_ticks < 4000));
    }
}

TEST_CASE("missed_time: any number of missed ticks is counted without overflow")
{
    missed_time missed = budget_at_start(1.0);
    for (int i = 0; i < 100; i++) {
        missed_time_step(&missed, UINT32_MAX);
        CHECK(missed_time_is_over(&missed));
    }
}
