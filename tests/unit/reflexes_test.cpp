/* The loop's reflexes: each with what trips it, and what does not. */
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <string>

#include "fault_bench.h"
#include "firmware/pi.h"
#include "seeded.h"

namespace
{

using bench::app_bench;
using bench::check_led_to_rest;
using bench::running_bench;

constexpr std::int64_t tick_period_ns = 2500000;

/* A robot as the configuration says it is: 17.5 ms from setpoint to motion, reports a tick old. */
app_config sensitive_config()
{
    app_config config = config_default();
    config.hardware.setpoint_to_motion_ms = 17.5;
    config.hardware.report_age_ms = 2.5;
    config.reflex.following_error_m = 0.005;
    config.reflex.following_error_ms = 20.0;
    config.reflex.link_quality = 0.5;
    config.reflex.link_quality_window_s = 1.0;
    config.reflex.dead_time_power_W = 10.0;
    config.reflex.dead_time_power_window_s = 0.5;
    return config;
}

/* Ticks of a sine of 0.1 m and 1 Hz, reported by a robot that is `late_ms` later than it is told to be. */
class following_bench
{
  public:
    explicit following_bench(const app_config &config = sensitive_config()) { reflexes_start(&reflexes_, &config); }

    bool tick(double late_ms, double offset_m = 0.0, bool has_report = true)
    {
        const double time_s = 2.5e-3 * static_cast<double>(++index_);
        reflex_input in{};
        in.now_ns = index_ * tick_period_ns;
        in.setpoint_m = at(time_s - 2.5e-3);
        in.reported_m = at(time_s - 1e-3 * (17.5 + 2.5 + late_ms)) + offset_m;
        in.has_report = has_report;
        return (reflexes_step(&reflexes_, &in) & REFLEX_FOLLOWING_ERROR) != 0;
    }
    double error_m() const { return reflexes_.following.error_m; }

  private:
    static double at(double time_s) { return time_s < 0.0 ? 0.0 : 0.1 * std::sin(berth::two_pi * time_s); }

    reflexes reflexes_;
    std::int64_t index_ = 0;
};

/* Share of `ticks` after which the quality is too low, for frames that come with these probabilities. */
struct quality_row {
    double report_probability, sample_probability;
    bool acts;
};

} // namespace

TEST_CASE("reflexes: a robot that follows by its dead time has no following error")
{
    following_bench bench;
    double worst_m = 0.0;
    for (int i = 0; i < 4000; i++) {
        REQUIRE_FALSE(bench.tick(0.0));
        worst_m = std::fmax(worst_m, i > 20 ? std::fabs(bench.error_m()) : 0.0);
    }
    CHECK(worst_m < 1e-4);
}

TEST_CASE("reflexes: a dead time that is told wrong shows as following error, by velocity times time")
{
    following_bench bench;
    double worst_m = 0.0;
    for (int i = 0; i < 4000; i++) {
        bench.tick(4.0);
        worst_m = std::fmax(worst_m, i > 20 ? std::fabs(bench.error_m()) : 0.0);
    }
    CHECK(worst_m == doctest::Approx(0.1 * berth::two_pi * 4e-3).epsilon(0.01));
}

TEST_CASE("reflexes: a following error acts when it has lasted, and only then")
{
    for (const double sign : {1.0, -1.0}) {
        CAPTURE(sign);
        following_bench bench;
        for (int i = 0; i < 100; i++) {
            bench.tick(0.0);
        }
        for (int i = 0; i < 400; i++) { /* never 20 ms in a row */
            REQUIRE_FALSE(bench.tick(0.0, i % 8 == 7 ? 0.0 : sign * 0.01));
        }
        for (int i = 0; i < 400; i++) {
            REQUIRE_FALSE(bench.tick(0.0, sign * 0.0049));
        }
        int ticks = 0;
        while (!bench.tick(0.0, sign * 0.0051)) {
            ticks++;
            REQUIRE(ticks < 100);
        }
        CHECK(ticks == 8);
        CHECK_FALSE(bench.tick(0.0));
    }
}

TEST_CASE("reflexes: without reports nothing is known of the following error")
{
    following_bench bench;
    for (int i = 0; i < 100; i++) {
        REQUIRE_FALSE(bench.tick(0.0));
    }
    for (int i = 0; i < 100; i++) {
        REQUIRE_FALSE(bench.tick(0.0, 1.0, false));
    }
}

TEST_CASE("reflexes: following error switched off")
{
    app_config config = sensitive_config();
    config.reflex.following_error_m = __builtin_inf();
    following_bench bench(config);
    for (int i = 0; i < 400; i++) {
        REQUIRE_FALSE(bench.tick(0.0, 1e6));
    }
}

TEST_CASE("reflexes: a link that brings too few frames acts, one that brings enough does not")
{
    SEEDED(random, "reflexes: a link*");
    const quality_row rows[] = {
        {1.0, 1.0, false}, {0.7, 1.0, false}, {1.0, 0.7, false}, {0.7, 0.7, false},
        {0.3, 1.0, true},  {1.0, 0.3, true},  {0.0, 1.0, true},
    };
    for (const quality_row &row : rows) {
        CAPTURE(row.report_probability);
        CAPTURE(row.sample_probability);
        const app_config config = sensitive_config();
        reflexes reflexes;
        reflexes_start(&reflexes, &config);
        reflex_input in{};
        bool acts = false;
        for (int i = 0; i < 4000; i++) {
            in.is_running = 1;
            in.has_report = seeded::uniform(random, 0.0, 1.0) < row.report_probability;
            in.has_sample = seeded::uniform(random, 0.0, 1.0) < row.sample_probability;
            acts = acts || (reflexes_step(&reflexes, &in) & REFLEX_LINK_QUALITY) != 0;
            REQUIRE((!acts || row.acts));
            REQUIRE((!acts || i > 100)); /* not before a good part of the window */
        }
        CHECK(acts == row.acts);
        in.is_running = 0;
        CHECK((reflexes_step(&reflexes, &in) & REFLEX_LINK_QUALITY) == 0);
        in.is_running = 1;
        CHECK((reflexes_step(&reflexes, &in) & REFLEX_LINK_QUALITY) == 0); /* it begins anew */
    }
}

TEST_CASE("reflexes: a sensor slower than the loop brings as many samples as it can")
{
    app_config config = sensitive_config();
    config.sensor_channel.rate_Hz = 100.0;
    reflexes reflexes;
    reflexes_start(&reflexes, &config);
    bool acts = false;
    for (int i = 0; i < 4000; i++) {
        reflex_input in{};
        in.is_running = in.has_report = 1;
        in.has_sample = i % 4 == 0 && (i < 2000 || i % 16 == 0);
        const bool now = (reflexes_step(&reflexes, &in) & REFLEX_LINK_QUALITY) != 0;
        REQUIRE((!now || i > 2000));
        acts = acts || now;
    }
    CHECK(acts);
}

TEST_CASE("reflexes: power that dead time makes acts beyond its limit, and a swing about nothing does not")
{
    const struct {
        double power_W, swing_J;
        bool acts;
    } rows[] = {{9.0, 0.0, false}, {11.0, 0.0, true}, {0.0, 0.1, false}, {-1000.0, 0.0, false}};
    for (const auto &row : rows) {
        CAPTURE(row.power_W);
        const app_config config = sensitive_config();
        reflexes reflexes;
        reflexes_start(&reflexes, &config);
        bool acts = false;
        for (int i = 0; i < 4000; i++) {
            const double time_s = 2.5e-3 * i;
            reflex_input in{};
            in.is_running = i > 0;
            in.dead_time_J = i < 2 ? 500.0 * (1 - i) /* of the run before */
                                   : row.power_W * time_s + row.swing_J * std::sin(berth::two_pi * time_s);
            acts = acts || (reflexes_step(&reflexes, &in) & REFLEX_DEAD_TIME_POWER) != 0;
        }
        CHECK(acts == row.acts);
    }
}

TEST_CASE("reflexes: energy that nobody gave acts beyond its limit, energy that the operator gave does not")
{
    app_config config = sensitive_config();
    config.reflex.growth_J = 10.0;
    const struct {
        double stored_J, operator_J;
        bool acts;
    } rows[] = {
        {10.9, 0.0, false}, {11.1, 0.0, true}, {1000.0, 989.1, false}, {1000.0, 988.9, true}, {0.0, 50.0, false}};
    for (const auto &row : rows) {
        CAPTURE(row.stored_J);
        CAPTURE(row.operator_J);
        reflexes reflexes;
        reflexes_start(&reflexes, &config);
        reflex_input in{};
        in.stored_J = 7000.0; /* of the run before */
        REQUIRE((reflexes_step(&reflexes, &in) & REFLEX_GROWTH) == 0);
        in.is_running = 1;
        in.stored_J = 1.0; /* where it begins */
        REQUIRE((reflexes_step(&reflexes, &in) & REFLEX_GROWTH) == 0);
        in.stored_J = row.stored_J;
        in.operator_J = row.operator_J;
        CHECK(((reflexes_step(&reflexes, &in) & REFLEX_GROWTH) != 0) == row.acts);
        in.is_running = 0;
        CHECK((reflexes_step(&reflexes, &in) & REFLEX_GROWTH) == 0);
    }
}

TEST_CASE("reflexes: a loop that diverges is stopped before the position limit, unless that is switched off")
{
    for (const double growth_J : {20.0, static_cast<double>(__builtin_inf())}) {
        CAPTURE(growth_J);
        app_config config = bench::moving_config();
        config.reflex.growth_J = growth_J;
        config.reflex.dead_time_power_W = __builtin_inf();
        app_bench bench(config);
        bench.request = OPERATOR_RUN;
        REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
        double furthest_m = 0.0;
        for (int i = 0; i < 8000 && bench.state() == SUPERVISOR_RUNNING; i++) {
            /* A damper that drives. */
            bench.force_N = std::round(-1000.0 * bench.app().manipulator.velocity_m_per_s);
            bench.tick();
            furthest_m = std::fmax(furthest_m, std::fabs(bench.app().recorder.tick.command_position_m));
        }
        CHECK(bench.state() == SUPERVISOR_FAULT);
        CHECK(bench.cause() == (growth_J < 100.0 ? STOP_GROWTH : STOP_POSITION_LIMIT));
        CHECK((furthest_m < 0.1) == (growth_J < 100.0)); /* 20 J at 7.9 kN/m are 71 mm */
    }
}

TEST_CASE("reflexes: a robot that leaves its setpoints is a fault of its own, and led to rest")
{
    app_bench bench = running_bench();
    bench.corrupt = [](hal_frame &frame) {
        if (frame.id == BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID) {
            berth_can_robot_feedback_t raw{};
            berth_can_robot_feedback_unpack(&raw, frame.data, 8);
            raw.position_m += 3000000000; /* 30 mm */
            berth_can_robot_feedback_pack(frame.data, &raw, 8);
        }
    };
    int ticks = 0;
    while (bench.state() == SUPERVISOR_RUNNING && ticks < 100) {
        bench.tick();
        ticks++;
    }
    CHECK(ticks == 21); /* 50 ms after the first */
    check_led_to_rest(bench, SUPERVISOR_FAULT, STOP_FOLLOWING_ERROR);
}

TEST_CASE("reflexes: a link of which most frames are lost is a fault of its own")
{
    for (const std::uint32_t id : {BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID, BERTH_CAN_FORCE_FRAME_ID}) {
        CAPTURE(id);
        app_bench bench = running_bench();
        int number = 0;
        bench.corrupt = [=](hal_frame &frame) mutable {
            frame.length = frame.id == id && number++ % 4 != 0 ? std::uint8_t{0} : frame.length;
        };
        int ticks = 0;
        while (bench.state() == SUPERVISOR_RUNNING && ticks < 4000) {
            bench.tick();
            ticks++;
        }
        CHECK(bench.cause() == STOP_LINK_QUALITY);
        CHECK(ticks > 400);
    }
}
