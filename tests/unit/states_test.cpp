/* What each state of the supervisor means for the motion, at the level of app_step. */
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "fault_bench.h"

namespace
{

using bench::app_bench;
using bench::change;
using bench::check_led_to_rest;
using bench::running_bench;
using bench::sent_setpoint;

} // namespace

TEST_CASE("states: a setpoint beyond the position range is a fault")
{
    app_config config = bench::moving_config();
    config.limits.position_max_m = 0.02;
    app_bench bench(config);
    bench.request = OPERATOR_RUN;
    bench.operator_position_m = 0.5;
    REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
    REQUIRE(bench.run_until(SUPERVISOR_FAULT));
    CHECK(bench.cause() == STOP_POSITION_LIMIT);
    CHECK(bench.app().recorder.tick.command_position_m <= 0.02);
    check_led_to_rest(bench, SUPERVISOR_FAULT, STOP_POSITION_LIMIT);
}

TEST_CASE("states: an integrator that leaves the numbers is a fault, nothing of it gets out, and a reset cures it")
{
    for (const int with_inverse_filter : {0, 1}) {
        CAPTURE(with_inverse_filter);
        app_config config = bench::moving_config();
        config.manipulator.stiffness_N_per_m = 1e18; /* far beyond what the step can follow */
        config.manipulator.integrator = INTEGRATOR_RK4;
        config.manipulator.substeps = 1000;
        config.inverse_filter = {with_inverse_filter, 12.0, 0.5, 40.0};
        REQUIRE(config_validate(&config).key == nullptr);
        app_bench bench(config);
        bench.request = OPERATOR_RUN;
        REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
        bench.tick();
        CHECK_FALSE(std::isfinite(bench.app().recorder.tick.manipulator_position_m));
        CHECK(std::isfinite(bench.app().recorder.tick.command_position_m));
        bench.tick();
        CHECK(bench.state() == SUPERVISOR_FAULT);
        CHECK(bench.cause() == STOP_NOT_FINITE);
        check_led_to_rest(bench, SUPERVISOR_FAULT, STOP_NOT_FINITE);
        bench.request = OPERATOR_RESET;
        CHECK(bench.run_until(SUPERVISOR_START, 10));
        bench.request = OPERATOR_NONE;
        CHECK(bench.run_until(SUPERVISOR_READY, 10));
    }
}

TEST_CASE("states: a stop request leads to rest first, then to stopped, where nothing is commanded any more")
{
    app_bench bench = running_bench();
    bench.stop = 1;
    bench.tick();
    CHECK(bench.state() == SUPERVISOR_HOLDING);
    CHECK(bench.cause() == STOP_REQUESTED);
    REQUIRE(bench.run_until(SUPERVISOR_STOPPED));
    CHECK(limits_at_rest(&bench.app().limits) != 0);
    CHECK(bench.cause() == STOP_REQUESTED);
    bench.stop = 0;
    bench.request = OPERATOR_RUN;
    for (int i = 0; i < 100; i++) {
        bench.tick();
        for (std::uint32_t n = 0; n < bench.out().frame_count; n++) {
            REQUIRE(bench.out().frames[n].id == BERTH_CAN_LOOP_STATUS_FRAME_ID);
        }
    }
    CHECK(bench.state() == SUPERVISOR_STOPPED);
}

TEST_CASE("states: a stop request in a fault waits for rest and keeps the cause of the fault")
{
    app_bench bench = running_bench();
    bench.saturated = true;
    bench.stop = 1;
    bench.tick();
    CHECK(bench.state() == SUPERVISOR_FAULT);
    REQUIRE(std::fabs(bench.app().limits.velocity_m_per_s) > 1e-3);
    while (bench.state() == SUPERVISOR_FAULT) {
        CHECK(sent_setpoint(bench).motion_allowed == 0);
        bench.tick();
    }
    CHECK(bench.state() == SUPERVISOR_STOPPED);
    CHECK(bench.cause() == STOP_SENSOR_SATURATED);
    CHECK(limits_at_rest(&bench.app().limits) != 0);
}

TEST_CASE("states: the loop gets ready only with the robot at its place and everything fresh")
{
    const struct {
        const char *name;
        change spoil, repair;
    } rows[] = {
        {"robot elsewhere", [](app_bench &b) { b.has_robot = false, b.robot_position_m = 0.0121; },
         [](app_bench &b) { b.robot_position_m = 0.0119; }},
        {"no feedback", [](app_bench &b) { b.has_feedback = false; }, [](app_bench &b) { b.has_feedback = true; }},
        {"no force", [](app_bench &b) { b.has_force = false; }, [](app_bench &b) { b.has_force = true; }},
        {"no operator", [](app_bench &b) { b.has_operator = false; }, [](app_bench &b) { b.has_operator = true; }},
        {"sensor saturated", [](app_bench &b) { b.saturated = true; }, [](app_bench &b) { b.saturated = false; }},
    };
    for (const auto &row : rows) {
        CAPTURE(std::string(row.name));
        app_bench bench;
        bench.request = OPERATOR_RUN;
        row.spoil(bench);
        bench.run(100);
        CHECK(bench.state() == SUPERVISOR_START);
        row.repair(bench);
        bench.tick();
        CHECK(bench.state() == SUPERVISOR_READY);
    }
}

TEST_CASE("states: in no state but running does the manipulator integrate")
{
    const struct {
        supervisor_state state;
        change reach;
    } rows[] = {
        {SUPERVISOR_START, [](app_bench &b) { b.has_feedback = false; }},
        {SUPERVISOR_READY, [](app_bench &b) { b.request = OPERATOR_NONE; }},
        {SUPERVISOR_HOLDING, [](app_bench &b) { b.run(2), b.has_force = false; }},
        {SUPERVISOR_FAULT, [](app_bench &b) { b.emergency_stop = 1; }},
        {SUPERVISOR_STOPPED, [](app_bench &b) { b.stop = 1; }},
    };
    for (const auto &row : rows) {
        CAPTURE(std::string(supervisor_state_name(row.state)));
        app_bench bench;
        bench.request = OPERATOR_RUN;
        row.reach(bench);
        REQUIRE(bench.run_until(row.state));
        bench.force_N = -500.0; /* it would fly off */
        bench.operator_position_m = 0.5;
        const manipulator before = bench.app().manipulator;
        bench.run(100);
        CHECK(bench.state() == row.state);
        CHECK(bench.app().manipulator.position_m == before.position_m);
        CHECK(bench.app().manipulator.velocity_m_per_s == before.velocity_m_per_s);
    }
    app_bench bench = running_bench();
    const double before_m = bench.app().manipulator.position_m;
    bench.tick();
    CHECK(bench.app().manipulator.position_m != before_m);
}

TEST_CASE("states: the heartbeat toggles every tick, in every state")
{
    app_bench bench;
    bench.tick();
    std::uint8_t level = bench.out().heartbeat;
    for (int i = 0; i < 300; i++) {
        bench.request = i > 50 ? OPERATOR_RUN : OPERATOR_NONE;
        bench.emergency_stop = i > 150;
        bench.stop = i > 250;
        bench.tick();
        REQUIRE(bench.out().heartbeat == (level ^ 1));
        level ^= 1;
    }
    CHECK(bench.state() == SUPERVISOR_STOPPED);
}
