/* The lines of the simulated rig from their other end. */
#include <atomic>
#include <doctest/doctest.h>

#include "../support/closed_loop.h"

namespace berth
{

namespace
{

std::uint8_t input(closed_loop &loop, hal_line line)
{
    std::uint8_t level = 0xff;
    CHECK(hal_gpio_get(loop.hal(), line, &level) == HAL_OK);
    return level;
}

} // namespace

TEST_CASE("simulated lines: what is set is there, and what is pressed is read")
{
    closed_loop loop("ess");
    REQUIRE(loop.tick());
    for (const std::uint8_t level : {1, 0, 1}) {
        hal_gpio_set(loop.hal(), HAL_LINE_FAULT, level);
        CHECK(sim_output(loop.hal(), HAL_LINE_FAULT) == level);
        hal_gpio_set(loop.hal(), HAL_LINE_HEARTBEAT, level);
        CHECK(sim_output(loop.hal(), HAL_LINE_HEARTBEAT) == level);
        sim_set_input(loop.hal(), HAL_LINE_EMERGENCY_STOP, level);
        CHECK(input(loop, HAL_LINE_EMERGENCY_STOP) == level);
        sim_set_input(loop.hal(), HAL_LINE_ENABLE, level);
        CHECK(input(loop, HAL_LINE_ENABLE) == level);
    }
}

TEST_CASE("simulated lines: the heartbeat toggles every tick")
{
    closed_loop loop("ess");
    for (int i = 0; i < 20; i++) {
        const std::uint8_t before = sim_output(loop.hal(), HAL_LINE_HEARTBEAT);
        REQUIRE(loop.tick());
        CHECK(sim_output(loop.hal(), HAL_LINE_HEARTBEAT) != before);
    }
}

TEST_CASE("simulated lines: the rig's schedule presses the emergency stop, gives the enable and takes it away")
{
    closed_loop loop("ess", {"run.emergency_stop_s=0.5", "run.enable_off_s=0.3", "run.duration_s=1"});
    while (loop.tick()) {
        const std::int64_t now_ns = loop.app().recorder.tick.scheduled_ns;
        CHECK(input(loop, HAL_LINE_EMERGENCY_STOP) == (now_ns >= 500000000 ? 1 : 0));
        CHECK(input(loop, HAL_LINE_ENABLE) == (now_ns == 0 || now_ns >= 300000000 ? 0 : 1));
    }
    CHECK(loop.app().supervisor.state == SUPERVISOR_FAULT);
    CHECK(loop.app().supervisor.stop_cause == STOP_EMERGENCY_STOP);
}

TEST_CASE("simulated lines: somebody asks for a stop, and every tick says so")
{
    std::atomic<bool> stop{false};
    struct hal *hal = sim_open(load_rig("ess"), {"", {}, &stop});
    hal_tick tick;
    REQUIRE(hal_wait_tick(hal, &tick) == HAL_OK);
    CHECK(tick.stop == 0);
    stop = true;
    for (int i = 0; i < 3; i++) {
        REQUIRE(hal_wait_tick(hal, &tick) == HAL_OK);
        CHECK(tick.stop != 0);
    }
    CHECK(hal_close(hal) == HAL_OK);
}

} // namespace berth
