/* A loop in motion, and what has to be seen when something stops it. */
#ifndef TESTS_UNIT_FAULT_BENCH_H
#define TESTS_UNIT_FAULT_BENCH_H

#include <doctest/doctest.h>

#include <cmath>
#include <functional>

#include "tick_builder.h"

namespace bench
{

using change = std::function<void(app_bench &)>;

constexpr int ticks_before_fault = 60;

inline app_bench running_bench()
{
    app_config config = moving_config();
    config.limits.acceleration_m_per_s2 = 1.0; /* a stop takes its time */
    app_bench bench(config);
    bench.request = OPERATOR_RUN;
    REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
    bench.run(ticks_before_fault);
    REQUIRE(bench.state() == SUPERVISOR_RUNNING);
    REQUIRE(std::fabs(bench.app().manipulator.velocity_m_per_s) > 1e-3); /* there is motion to be stopped */
    return bench;
}

inline berth_can_setpoint_t sent_setpoint(const app_bench &bench)
{
    berth_can_setpoint_t raw{};
    REQUIRE(bench.out().frame_count >= 1);
    REQUIRE(bench.out().frames[0].id == BERTH_CAN_SETPOINT_FRAME_ID);
    REQUIRE(berth_can_setpoint_unpack(&raw, bench.out().frames[0].data, 8) == 0);
    return raw;
}

/* While what went wrong lasts: setpoints go on, without leave to move, and brake to where the manipulator waits. */
inline void check_led_to_rest(app_bench &bench, supervisor_state state, stop_cause cause)
{
    const double stopped_at_m = bench.app().manipulator.position_m;
    const double acceleration_m_per_s2 = bench.app().config.limits.acceleration_m_per_s2;
    const double speed_m_per_s = std::fabs(bench.app().limits.velocity_m_per_s);
    const double braking_m = speed_m_per_s * speed_m_per_s / acceleration_m_per_s2 + 1e-4;
    for (int i = 0; i < 100; i++) {
        bench.tick();
        REQUIRE(bench.state() == state);
        REQUIRE(bench.cause() == cause);
        REQUIRE(bench.app().manipulator.position_m == stopped_at_m); /* it does not integrate */
        REQUIRE(bench.app().manipulator.velocity_m_per_s == 0.0);
        REQUIRE(sent_setpoint(bench).motion_allowed == 0);
        REQUIRE(std::fabs(bench.app().recorder.tick.command_position_m - stopped_at_m) <= braking_m);
    }
    CHECK(limits_at_rest(&bench.app().limits) != 0);
}

} // namespace bench

#endif
