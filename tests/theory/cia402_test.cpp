/* Profile "cia402": firmware and simulated drive over the simulated bus. A synchronous setpoint acts at the SYNC of
 * the next tick, and that tick of dead time is in run, measurement and eigenvalues alike. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

#include "../../firmware/canopen.h"
#include "../../sim_hal/hil/deadtime.h"
#include "../../sim_hal/hil/wake_histogram.h"
#include "../../sim_hal/stability/gains.h"
#include "../../sim_hal/stability/lyapunov.h"
#include "../../sim_hal/stability/physical_parameter.h"
#include "../../sim_hal/stability/spectrum.h"
#include "../support/closed_loop.h"

namespace berth
{

namespace
{

constexpr double growth_agrees = 0.02;

std::vector<std::string> drive(std::vector<std::string> overrides = {})
{
    overrides.insert(overrides.begin(), {"robot_channel.profile=cia402", "run.release_s=1"});
    return overrides;
}

double measured_ms(const std::string &name, std::vector<std::string> overrides)
{
    overrides.emplace_back("run.duration_s=1000");
    const rig rig = load_rig(name, drive(std::move(overrides)));
    struct hal *hal = sim_open(rig);
    deadtime_measurement measured;
    CHECK(measure_drive_deadtime(hal, rig.firmware, 1e-3, 0.3, measured) == HAL_OK);
    hal_close(hal);
    return 1e3 * measured.command_to_motion_s;
}

double run_growth_per_s(const rig &rig)
{
    closed_loop loop(rig);
    const std::vector<double> position_m = free_motion_m(loop);
    REQUIRE(loop.is_running());
    const auto fit = fit_growth(position_m, config_period_s(&rig.firmware), 1e-7);
    REQUIRE(fit);
    return fit->growth_per_s;
}

} // namespace

TEST_CASE("cia402: a setpoint is displayed one tick later than the drive's own dead time")
{
    constexpr double tolerance_ms = 1e-6;
    CHECK(std::abs(measured_ms("ess", {}) - (17.5 + 2.5)) < tolerance_ms);
    CHECK(std::abs(measured_ms("ess", {"robot.dead_time_ms=2.5"}) - (2.5 + 2.5)) < tolerance_ms);
    CHECK(std::abs(measured_ms("ess", {"robot.dead_time_ms=11.3"}) - (11.3 + 2.5)) < tolerance_ms);
    CHECK(std::abs(measured_ms("ess-50hz", {}) - (40.0 + 20.0)) < tolerance_ms);
    CHECK(std::abs(measured_ms("ess", {"loop.rate_Hz=1000"}) - (17.5 + 1.0)) < tolerance_ms);
}

TEST_CASE("cia402: the eigenvalues are those of the same rig with one more tick of dead time")
{
    for (const auto &[rig_name, longer] :
         {std::pair{"ess", "robot.dead_time_ms=20"}, std::pair{"ess-50hz", "robot.dead_time_ms=60"}}) {
        const spectrum with_drive = loop_spectrum(load_rig(rig_name, drive()));
        const spectrum expected = loop_spectrum(load_rig(rig_name, {longer}));
        CHECK(with_drive.growth_per_s == doctest::Approx(expected.growth_per_s).epsilon(1e-9));
    }
}

TEST_CASE("cia402: at another rate the tick of dead time is one of that rate, delays in ms or in ticks")
{
    const rig with_drive = load_rig("ess", drive());
    const struct {
        delays_stay delays;
        double dead_time_ms; /* of the same rig without a drive, at its own rate */
    } cases[] = {{delays_stay::in_ticks, 20.0}, {delays_stay::in_ms, 17.5 + 5.0}};
    for (const auto &[delays, dead_time_ms] : cases) {
        rig expected = load_rig("ess", {"robot.dead_time_ms=" + std::to_string(dead_time_ms)});
        expected = at_rate(expected, 200.0, delays);
        const spectrum found = loop_spectrum(at_rate(with_drive, 200.0, delays));
        CHECK(found.growth_per_s == doctest::Approx(loop_spectrum(expected).growth_per_s).epsilon(1e-9));
    }
}

TEST_CASE("cia402: what helps most includes those rates whose period a drive can take")
{
    constexpr double step = 0.02; /* half of 1 / 26: the coarsest that 0x60C2 tells periods */
    for (const double share : {0.1, 0.5}) {
        const std::vector<parameter_gain> gains = find_gains(load_rig("ess", drive()), share);
        const auto rates = std::count_if(gains.begin(), gains.end(), [&](const parameter_gain &gain) {
            return gain.key == "loop.rate_Hz" && gain.less && gain.more &&
                   std::abs(gain.less->value / 400.0 - (1.0 - share)) < step &&
                   std::abs(gain.more->value / 400.0 - (1.0 + share)) < step;
        });
        CHECK(rates == 2);
    }
}

TEST_CASE("cia402: of a rate that a drive cannot be told, the nearest that it can")
{
    CHECK_THROWS_WITH_AS(load_rig("ess", drive({"loop.rate_Hz=160"})),
                         doctest::Contains("the nearest whole rates that do are 125 and 200 Hz"), input_error);
    CHECK_THROWS_WITH_AS(load_rig("ess", {"loop.rate_Hz=170"}),
                         doctest::Contains("the nearest whole rates that do are 160 and 200 Hz"), input_error);
}

TEST_CASE("cia402: the closed loop grows as its eigenvalues say, within 2 %")
{
    const struct {
        const char *rig;
        std::vector<std::string> overrides;
        bool tick_matters; /* without the tick the prediction would miss by more than is allowed */
    } cases[] = {
        {"ess", {}, false},
        {"ess-50hz", {}, true},
        {"ess", {"robot.dead_time_ms=2.5", "object.stiffness_N_per_m=9000"}, true},
        {"ess", {"object.stiffness_N_per_m=10500"}, true}, /* stable without the tick, unstable with it */
        {"ess", {"loop.rate_Hz=1000", "robot.dead_time_ms=6.3", "robot.interpolation=hold"}, false},
    };
    for (const auto &one : cases) {
        CAPTURE(std::string(one.rig));
        std::vector<std::string> overrides = drive(one.overrides);
        overrides.emplace_back("cia402.counts_per_m=2e9");
        overrides.emplace_back("run.duration_s=30");
        const rig rig = load_rig(one.rig, overrides);
        const double predicted = loop_spectrum(rig).growth_per_s;
        const double measured = run_growth_per_s(rig);
        CHECK(std::abs(measured / predicted - 1.0) < growth_agrees);
        const double without = loop_spectrum(load_rig(one.rig, one.overrides)).growth_per_s;
        CHECK((std::abs(measured / without - 1.0) > growth_agrees) == one.tick_matters);
        MESSAGE(std::string(one.rig) << ": measured " << measured << " /s, predicted " << predicted
                                     << ", without the tick " << without);
    }
}

TEST_CASE("cia402: a drive in fault stops the loop, and goes on when its error is over and a person has reset it")
{
    closed_loop loop("ess", drive({"run.duration_s=100"}));
    const auto run = [&](double duration_s) {
        for (int i = 0; i < static_cast<int>(400 * duration_s); i++) {
            REQUIRE(loop.tick());
        }
    };
    const auto state = [&] { return loop.app().supervisor.state; };
    virtual_rig &rig = sim_rig(loop.hal());
    run(2.0);
    REQUIRE(loop.is_running());
    rig.set_robot_fault(true);
    run(0.01);
    CHECK(state() == SUPERVISOR_FAULT);
    CHECK(loop.app().supervisor.stop_cause == STOP_ROBOT_FAULT);
    CHECK(loop.app().recorder.tick.drive_error == 0x2310);
    const double held_m = loop.truth().robot_position_m;
    rig.operators().set_request(OPERATOR_RESET);
    run(1.0); /* its error is still there */
    CHECK(state() == SUPERVISOR_FAULT);
    rig.set_robot_fault(false);
    rig.operators().set_request(OPERATOR_NONE);
    run(1.0);
    CHECK(state() == SUPERVISOR_FAULT);
    CHECK(std::abs(loop.truth().robot_position_m - held_m) < 2e-3);
    rig.operators().set_request(OPERATOR_RESET);
    run(1.0);
    CHECK(state() == SUPERVISOR_READY);
    rig.operators().set_request(OPERATOR_RUN);
    run(1.0);
    CHECK(state() == SUPERVISOR_READY); /* the enable has to be given anew */
    for (const std::uint8_t level : {0, 1}) {
        sim_set_input(loop.hal(), HAL_LINE_ENABLE, level);
        run(0.1);
    }
    CHECK(loop.is_running());
}

TEST_CASE("cia402: a single frame lost changes no state, and losses are in the prediction")
{
    const rig rig = load_rig("ess", drive({"bus.loss_probability=0.01", "run.duration_s=60"}));
    closed_loop loop(rig);
    std::vector<double> position_m;
    while (loop.tick()) {
        if (loop.is_running()) {
            position_m.push_back(loop.app().recorder.tick.manipulator_position_m);
        }
    }
    CHECK(loop.is_running());
    CHECK(position_m.size() > 23000);
    const auto fit = fit_growth(position_m, config_period_s(&rig.firmware), 1e-6);
    REQUIRE(fit);
    const lyapunov_exponent predicted = exponent_of(rig, load_wake_histogram(rig));
    CHECK(std::abs(fit->growth_per_s / predicted.growth_per_s - 1.0) < growth_agrees);
}

TEST_CASE("cia402: without SYNC no setpoint acts")
{
    const rig rig = load_rig("ess", drive());
    virtual_rig far(rig);
    closed_loop loop(rig);
    std::int64_t now_ns = 0;
    const std::int64_t period_ns = config_period_ns(&rig.firmware);
    /* What the loop sends goes to a second rig as well, which hears no SYNC from some tick on. */
    const auto step = [&](bool with_sync) {
        REQUIRE(loop.tick());
        far.advance_to(now_ns);
        hal_frame frame;
        while (far.bus(HAL_BUS_ROBOT).receive(now_ns, frame) || far.bus(HAL_BUS_SENSOR).receive(now_ns, frame)) {
        }
        const struct recorder &recorder = loop.app().recorder;
        for (std::size_t at = 0; at < recorder.size_bytes;) {
            const std::uint8_t *message = recorder.bytes + at;
            at += 3u + message[0] + 256u * message[1];
            if (message[3] != ULOG_FRAME_ID) {
                continue;
            }
            frame_record record;
            std::memcpy(&record, message + ULOG_DATA_HEADER_BYTES, sizeof record);
            if (record.direction == 1 && (with_sync || record.id != CANOPEN_SYNC_ID)) {
                hal_frame sent{now_ns, record.id, record.bus, record.length, 0, 0, {}};
                std::memcpy(sent.data, &record.data, sizeof sent.data);
                far.receive_from_loop(sent);
            }
        }
        now_ns += period_ns;
    };
    for (int i = 0; i < 500; i++) {
        step(true);
    }
    REQUIRE(loop.is_running());
    const double moving_m = far.truth().robot_position_m;
    CHECK(moving_m == doctest::Approx(loop.truth().robot_position_m).epsilon(1e-6));
    for (int i = 0; i < 10; i++) {
        step(false);
    }
    const double stopped_m = far.truth().robot_position_m;
    for (int i = 0; i < 60; i++) {
        step(false);
    }
    CHECK(far.truth().robot_position_m == stopped_m);
    CHECK(std::abs(loop.truth().robot_position_m - stopped_m) > 1e-3);
}

} // namespace berth
