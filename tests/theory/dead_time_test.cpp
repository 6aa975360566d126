/* Dead time from command to motion, measured through the seam, against what the rig was told. */
#include <cmath>
#include <doctest/doctest.h>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/hil/deadtime.h"
#include "../../sim_hal/hil/random.h"
#include "../../sim_hal/hil/sim_hal.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

deadtime_measurement measure(const std::string &name, std::vector<std::string> overrides, double watch_s = 0.3)
{
    overrides.push_back("run.duration_s=1000");
    const rig rig = load_rig(name, overrides);
    struct hal *hal = sim_open(rig);
    deadtime_measurement measured;
    CHECK(measure_deadtime(hal, rig.firmware, 1e-3, watch_s, measured) == HAL_OK);
    CHECK(hal_close(hal) == HAL_OK);
    return measured;
}

std::string dead_time(double dead_time_ms)
{
    return "robot.dead_time_ms=" + std::to_string(dead_time_ms);
}

/* Feedback in steps of 10 pm on a step of 1 mm, one of them in each tick of the settled part at worst. */
constexpr double tolerance_s = 1e-9;

} // namespace

TEST_CASE("dead time of the reference cases: 17.5 ms at 400 Hz, 40 ms at 50 Hz")
{
    CHECK(std::abs(measure("ess", {}).command_to_motion_s - 17.5e-3) < tolerance_s);
    CHECK(std::abs(measure("ess-50hz", {}).command_to_motion_s - 40e-3) < tolerance_s);
    CHECK(std::abs(measure("ess-half-dead-time", {}).command_to_motion_s - 7.5e-3) < tolerance_s);
}

TEST_CASE("any real dead time is displayed to the nanosecond with straight lines")
{
    REPRODUCIBLE();
    random_stream random(test_seed(), 1);
    for (int i = 0; i < 50; i++) {
        const double dead_time_ms = std::round(1e6 * (2.5 + 57.5 * random.uniform())) * 1e-6;
        CAPTURE(dead_time_ms);
        const auto measured = measure("ess", {dead_time(dead_time_ms)});
        CHECK(std::abs(measured.command_to_motion_s - 1e-3 * dead_time_ms) < tolerance_s);
        /* The line starts one period earlier: the first tick after that sees motion (of 0.1 % at least). */
        CHECK(measured.first_motion_s <= 1e-3 * dead_time_ms + 1e-9);
        CHECK(measured.first_motion_s >= 1e-3 * dead_time_ms - 2.5e-3);
    }
}

TEST_CASE("with hold the jump comes at the first tick after the dead time")
{
    REPRODUCIBLE();
    random_stream random(test_seed(), 2);
    for (int i = 0; i < 50; i++) {
        const double dead_time_ms = std::round(1e6 * (0.405 + 60.0 * random.uniform())) * 1e-6;
        CAPTURE(dead_time_ms);
        const auto measured = measure("ess", {dead_time(dead_time_ms), "robot.interpolation=hold"});
        const double first_tick_s = 2.5e-3 * std::ceil(dead_time_ms / 2.5);
        CHECK(std::abs(measured.command_to_motion_s - first_tick_s) < tolerance_s);
        CHECK(std::abs(measured.first_motion_s - first_tick_s) < tolerance_s);
    }
}

/* The area between command and answer of G_R is its mean delay, 2 zeta / w, whatever the shape in between. */
TEST_CASE("transfer behaviour adds its mean delay 2 zeta / w")
{
    for (const double damping_ratio : {0.3, 0.7, 1.2}) {
        CAPTURE(damping_ratio);
        const auto measured = measure(
            "ess",
            {"robot.transfer_frequency_Hz=8", "robot.transfer_damping_ratio=" + std::to_string(damping_ratio)}, 3.0);
        const double lag_s = 2.0 * damping_ratio / (2.0 * M_PI * 8.0);
        /* The sum over ticks is a trapezoid rule: error T^2/12 times the answer's change of slope. */
        CHECK(std::abs(measured.command_to_motion_s - (17.5e-3 + lag_s)) < 1e-6);
    }
}

TEST_CASE("a dead time below one period is refused with straight lines and allowed with hold")
{
    CHECK_THROWS_AS(load_rig("ess", {"robot.dead_time_ms=2.499999"}), input_error);
    CHECK_THROWS_WITH_AS(load_rig("ess", {"robot.dead_time_ms=1.0"}), doctest::Contains("robot.dead_time_ms"),
                         input_error);
    CHECK_NOTHROW(load_rig("ess", {"robot.dead_time_ms=2.5"}));
    CHECK_NOTHROW(load_rig("ess", {"robot.dead_time_ms=1.0", "robot.interpolation=hold"}));
}

/* Feedback and operator command go first on the robot's bus: three frames of 135 us. */
TEST_CASE("a dead time below the setpoint's time on the bus is refused, and so is a bus that cannot carry the loop")
{
    CHECK_THROWS_AS(load_rig("ess", {"robot.dead_time_ms=0.404", "robot.interpolation=hold"}), input_error);
    CHECK_NOTHROW(load_rig("ess", {"robot.dead_time_ms=0.405", "robot.interpolation=hold"}));
    CHECK(measure("ess", {"robot.dead_time_ms=0.405", "robot.interpolation=hold"}).command_to_motion_s ==
          doctest::Approx(2.5e-3));
    CHECK_THROWS_WITH_AS(load_rig("ess", {"loop.rate_Hz=2500"}), doctest::Contains("bus.bit_rate_bit_per_s"),
                         input_error);
    CHECK_NOTHROW(load_rig("ess", {"loop.rate_Hz=2000"}));
    CHECK_NOTHROW(load_rig("ess", {"loop.rate_Hz=10000", "bus.ideal=true"}));
}

} // namespace berth
