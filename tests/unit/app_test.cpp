/* The order of things within a tick: the newest force is taken, x_n is sent, then x_n+1 is computed with F_n. */
#include <doctest/doctest.h>

#include <cmath>

#include "seeded.h"
#include "tick_builder.h"

namespace
{

/* Where the setpoint frame of this tick sends the robot. */
double sent_position_m(const tick_output &out)
{
    berth_can_setpoint_t raw{};
    REQUIRE(out.frame_count >= 1);
    REQUIRE(out.frames[0].id == BERTH_CAN_SETPOINT_FRAME_ID);
    REQUIRE(berth_can_setpoint_unpack(&raw, out.frames[0].data, 8) == 0);
    return static_cast<double>(raw.position_m) * 1e-11;
}

} // namespace

TEST_CASE("app: sends x_n, then advances with the force and the command of the same tick")
{
    SEEDED(random, "app:*");
    const app_config config = bench::moving_config();
    bench::app_bench bench(config);
    bench.request = OPERATOR_RUN;
    REQUIRE(bench.run_until(SUPERVISOR_READY));
    bench.tick(); /* in which the operator sees it */
    manipulator expected;
    manipulator_start(&expected, &config);
    for (int n = 0; n < 1000; n++) {
        CAPTURE(n);
        bench.force_N = std::round(seeded::uniform(random, -50.0, 50.0));
        bench.operator_position_m = 1e-3 * std::round(seeded::uniform(random, -10.0, 10.0));
        bench.tick();
        REQUIRE(bench.state() == SUPERVISOR_RUNNING);
        REQUIRE(bench.app().limits.active == 0);
        REQUIRE(std::fabs(sent_position_m(bench.out()) - expected.position_m) <= 0.501e-11);
        const operator_command command = {bench.operator_position_m, 0.0, 0.0, OPERATOR_RUN};
        manipulator_step(&expected, &command, bench.force_N);
        REQUIRE(std::fabs(bench.app().manipulator.position_m - expected.position_m) <= 1e-12);
    }
}

TEST_CASE("app: of several force frames in a tick the newest counts")
{
    bench::app_bench bench;
    bench.run(3);
    bench.force_N = 1.0;
    bench.extra = {bench::force_frame(2.0, static_cast<std::uint8_t>(bench.force_counter + 1), bench.now_ns())};
    bench.tick();
    CHECK(bench.app().recorder.tick.force_N == doctest::Approx(2.0));
}

TEST_CASE("app: an app can be started again and then behaves as a new one")
{
    const app_config config = bench::moving_config();
    const auto traced = [&](struct app &app) {
        app_start(&app, &config);
        bench::app_bench source(config);
        source.request = OPERATOR_RUN;
        tick_output out{};
        for (int i = 0; i < 200; i++) {
            source.tick();
            app_step(&app, &source.in(), &out);
        }
        return app.recorder.tick.command_position_m;
    };
    const auto used = std::make_unique<struct app>();
    const double first_m = traced(*used);
    CHECK(traced(*used) == first_m);
    CHECK(used->reception.counts.repeated == 0);
}

TEST_CASE("app: many loops run beside each other without touching")
{
    std::vector<bench::app_bench> loops;
    for (int i = 0; i < 64; i++) {
        app_config config = bench::moving_config();
        config.manipulator.mass_kg = 100.0 + i;
        loops.emplace_back(config);
        loops.back().request = OPERATOR_RUN;
    }
    for (int n = 0; n < 200; n++) {
        for (bench::app_bench &loop : loops) {
            loop.tick();
        }
    }
    for (int i = 0; i < 64; i++) {
        CAPTURE(i);
        bench::app_bench alone(loops[static_cast<std::size_t>(i)].app().config);
        alone.request = OPERATOR_RUN;
        alone.run(200);
        CHECK(alone.app().recorder.tick.command_position_m ==
              loops[static_cast<std::size_t>(i)].app().recorder.tick.command_position_m);
    }
}
