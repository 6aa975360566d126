/* Setpoints that do not arrive are noticed: refused by the bus, or never taken by the robot. */
#include <doctest/doctest.h>

#include <functional>
#include <string>

#include "fault_bench.h"
#include "firmware/delivery.h"

namespace
{

using bench::app_bench;
using bench::change;
using bench::check_led_to_rest;
using bench::running_bench;

constexpr std::int64_t period_ns = 2500000;

/* A robot that takes setpoints some ticks after they were sent, and reports the newest. */
struct echoing_robot {
    setpoint_echo echo{};
    std::uint8_t newest = 0;
    std::int64_t tick = 0;

    std::int64_t age_ns() const { return tick * period_ns - echo.sent_ns; }
    void judge() { setpoint_echo_step(&echo, {newest, tick * period_ns}, period_ns, 100000000); }

    void step(int behind)
    {
        tick++;
        newest++;
        setpoint_echo_report(&echo, static_cast<std::uint8_t>(newest - behind));
        judge();
    }
    void stand_still()
    {
        tick++;
        newest++;
        setpoint_echo_report(&echo, echo.reported);
        judge();
    }
    void say_nothing()
    {
        tick++;
        newest++;
        judge();
    }
};

int ticks_until_fault(app_bench &bench, int ticks_max)
{
    int ticks = 0;
    while (bench.state() == SUPERVISOR_RUNNING && ticks < ticks_max) {
        bench.tick();
        ticks++;
    }
    return ticks;
}

} // namespace

TEST_CASE("delivery: the echo tells how old the newest setpoint is that the robot has")
{
    for (const int behind : {0, 1, 7, 100, 254}) {
        CAPTURE(behind);
        echoing_robot robot;
        for (int i = 0; i < 1000; i++) { /* the counter wraps around */
            robot.step(behind);
            REQUIRE((i == 0 || robot.echo.is_seen));
            REQUIRE((i == 0 || robot.age_ns() == behind * period_ns));
        }
    }
}

TEST_CASE("delivery: an echo that stands still gets older, also over a turn of the counter")
{
    echoing_robot robot;
    robot.step(0);
    robot.step(0);
    for (int i = 0; i < 1000; i++) {
        robot.stand_still();
        REQUIRE(robot.age_ns() == (i + 1) * period_ns);
        REQUIRE((robot.echo.is_stale != 0) == (i + 1 > 40));
    }
    for (int i = 0; i < 300; i++) { /* and it is believed again when it moves */
        robot.step(5);
    }
    CHECK(robot.age_ns() == 5 * period_ns);
    CHECK(robot.echo.is_stale == 0);
}

TEST_CASE("delivery: an echo that goes back is no news")
{
    echoing_robot robot;
    for (int i = 0; i < 20; i++) {
        robot.step(2);
    }
    robot.step(9);
    CHECK(robot.age_ns() == 3 * period_ns);
}

TEST_CASE("delivery: without feedback nothing is known of the echo, and it stays as it was judged")
{
    echoing_robot robot;
    robot.step(0);
    robot.step(0);
    for (int i = 0; i < 200; i++) {
        robot.say_nothing();
        REQUIRE(robot.echo.is_stale == 0);
    }
    robot.step(3);
    CHECK(robot.echo.is_stale == 0);
    robot.stand_still();
    CHECK(robot.echo.is_stale == 0);
}

TEST_CASE("delivery: nothing is seen before sending begins, whatever the robot reports then")
{
    setpoint_echo echo{};
    for (int i = 0; i < 10; i++) {
        setpoint_echo_report(&echo, 200);
        setpoint_echo_rest(&echo, i * period_ns);
        CHECK(echo.is_seen == 0);
    }
    setpoint_echo_step(&echo, {0, 10 * period_ns}, period_ns, 100000000);
    CHECK(echo.is_seen == 0);
    setpoint_echo_report(&echo, 0);
    setpoint_echo_step(&echo, {0, 11 * period_ns}, period_ns, 100000000);
    CHECK(echo.is_seen == 1);
}

TEST_CASE("delivery: refused frames count while no tick gets all of its own out")
{
    app_config config = config_default();
    config.robot_channel.unsent_after_ms = 10.0;
    refusal refusal;
    refusal_start(&refusal, &config);
    std::uint32_t unsent = 0;
    std::int64_t tick = 0;
    const auto step = [&](std::uint32_t refused, std::uint32_t sent) {
        unsent += refused;
        tick++;
        refusal_step(&refusal, unsent, sent, (tick - 1) * period_ns);
        return refusal_lasts(&refusal, tick * period_ns) != 0;
    };
    for (int i = 0; i < 4; i++) {
        CHECK_FALSE(step(1, 2));
    }
    CHECK(step(1, 2)); /* 12.5 ms after the first one */
    CHECK(step(0, 0)); /* a tick that sends nothing says nothing */
    CHECK_FALSE(step(0, 1));
    for (int i = 0; i < 100; i++) {
        CHECK_FALSE(step(i % 4 != 0, 1)); /* never four in a row */
    }
    unsent = refusal.unsent_frames = UINT32_MAX; /* the count wraps around */
    CHECK_FALSE(step(0, 1));
    for (int i = 0; i < 4; i++) {
        CHECK_FALSE(step(1, 1));
    }
    CHECK(step(1, 1));
}

TEST_CASE("delivery: a bus that takes no frame is a fault of its own, and stays one until it takes them again")
{
    app_bench bench = running_bench();
    bench.refuses_frames = true;
    CHECK(ticks_until_fault(bench, 400) == 1 + 8 + 1); /* refused in the first, known in the second, 20 ms */
    CHECK(bench.cause() == STOP_SEND_REFUSED);
    CHECK(bench.app().recorder.tick.unsent_frames >= 9);
    check_led_to_rest(bench, SUPERVISOR_FAULT, STOP_SEND_REFUSED);
    bench.request = OPERATOR_RESET;
    bench.run(100);
    CHECK(bench.state() == SUPERVISOR_FAULT);
    bench.refuses_frames = false;
    CHECK(bench.run_until(SUPERVISOR_READY, 10));
}

TEST_CASE("delivery: a robot that takes no setpoint any more is a fault of its own")
{
    const struct {
        const char *name;
        change spoil;
    } rows[] = {
        {"the echo stands still", [](app_bench &b) { b.echoes = false; }},
        {"the robot does not hear", [](app_bench &b) { b.has_robot = false; }},
    };
    for (const auto &row : rows) {
        CAPTURE(std::string(row.name));
        app_bench bench = running_bench();
        row.spoil(bench);
        const int ticks = ticks_until_fault(bench, 400);
        CHECK(ticks >= 40);
        CHECK(ticks <= 42); /* 100 ms */
        CHECK(bench.cause() == STOP_SETPOINT_STALE);
        check_led_to_rest(bench, SUPERVISOR_FAULT, STOP_SETPOINT_STALE);
    }
}

TEST_CASE("delivery: a robot that never echoes is never run, and is a fault of its own")
{
    app_bench bench;
    bench.echoes = false;
    bench.request = OPERATOR_RUN;
    for (int i = 0; i < 60; i++) {
        bench.tick();
        REQUIRE(bench.state() != SUPERVISOR_RUNNING);
    }
    CHECK(bench.state() == SUPERVISOR_FAULT);
    CHECK(bench.cause() == STOP_SETPOINT_STALE);
    bench.request = OPERATOR_RESET; /* there is nothing to be sent in start: the next try ends alike */
    CHECK(bench.run_until(SUPERVISOR_READY, 10));
    bench.request = OPERATOR_NONE;
    CHECK(bench.run_until(SUPERVISOR_FAULT, 50));
}

TEST_CASE("delivery: a robot that cannot echo is let pass if the rig says so")
{
    app_config config = bench::moving_config();
    config.robot_channel.setpoint_stale_after_ms = __builtin_inf();
    REQUIRE(config_validate(&config).key == nullptr);
    app_bench bench(config);
    bench.echoes = false;
    bench.request = OPERATOR_RUN;
    REQUIRE(bench.run_until(SUPERVISOR_RUNNING, 10));
    bench.run(1000);
    CHECK(bench.state() == SUPERVISOR_RUNNING);
}

TEST_CASE("delivery: every axis of the robot has to echo")
{
    app_config config = config_default();
    config.side_axes[SIDE_AXIS_Z].enabled = 1;
    robot_channel channel;
    reception reception;
    reception_start(&reception, &config);
    robot_channel_start(&channel, &config);
    channel.sends_setpoints = 1;
    for (int i = 1; i <= 60; i++) {
        channel.setpoint_counter = static_cast<std::uint8_t>(i + 1);
        channel.side_counter[SIDE_AXIS_Z] = static_cast<std::uint8_t>(i + 1);
        channel.setpoint_ns = i * period_ns;
        setpoint_echo_report(&channel.echo, static_cast<std::uint8_t>(i));
        setpoint_echo_report(&channel.side_echo[SIDE_AXIS_Z], static_cast<std::uint8_t>(i < 10 ? i : 10));
        robot_channel_end_receive(&channel, &reception, i * period_ns);
        CHECK((channel.setpoint_is_stale != 0) == (i > 50));
    }
}
