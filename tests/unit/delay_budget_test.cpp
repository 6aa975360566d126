/* The parts of the loop's delay, against what the rig file says and against the theory's own sum. */
#include <cmath>
#include <doctest/doctest.h>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/delay_budget.h"
#include "../../sim_hal/stability/first_order_limit.h"

namespace berth
{

TEST_CASE("delay budget: 34 ms of robot, 2 ms of sensor, and the low-pass of 20 Hz that nobody stated")
{
    const rig rig = parse_rig("[loop]\nrate_Hz = 500\n[robot]\ndead_time_ms = 34\n[sensor]\ndelay_ms = 2\n", "rig");
    const delay_budget budget = delay_budget_of(rig);
    const double frame_ms = 0.135; /* 135 bits at 1 Mbit/s: 8 bytes with all stuff bits */
    CHECK(budget.robot_ms == doctest::Approx(34.0 - 3 * frame_ms));
    CHECK(budget.sensor_ms == doctest::Approx(2.0 - frame_ms));
    CHECK(budget.bus_ms == doctest::Approx(4 * frame_ms));
    CHECK(budget.hold_ms == doctest::Approx(1.0));
    CHECK(budget.low_pass_ms == doctest::Approx(2e3 * 0.7 / (2 * M_PI * 20.0)));
    CHECK(budget.wait_ms == doctest::Approx(0.0));
    CHECK(budget.total_ms() == doctest::Approx(48.14).epsilon(1e-4));
}

TEST_CASE("delay budget: the parts are the whole")
{
    const std::vector<std::vector<std::string>> cases = {
        {},
        {"robot.interpolation=hold", "bus.ideal=true"},
        {"sensor.delay_ms=3.1", "sensor.sample_phase_ms=0.7"},
        {"robot.transfer_frequency_Hz=12", "inverse_filter.enabled=true"},
        {"robot.lag_ms=4", "sensor.lag_ms=1.5", "sensor.low_pass_order=1"},
        {"sensor.low_pass_order=0", "sensor.rate_Hz=800"},
        {"sensor_channel.layout=three_frames_intel"},
    };
    for (const shipped_file &shipped : shipped_rigs()) {
        rig rig = load_rig(shipped.name);
        rig.object.kind = object_kind::gripped; /* a contact without end: the loop delays nothing else */
        CAPTURE(shipped.name);
        CHECK(delay_budget_of(rig).total_ms() == doctest::Approx(1e3 * loop_delay_s(rig)));
    }
    for (const auto &overrides : cases) {
        const rig rig = load_rig("ess", overrides);
        CAPTURE((overrides.empty() ? "" : overrides.front()));
        CHECK(delay_budget_of(rig).total_ms() == doctest::Approx(1e3 * loop_delay_s(rig)));
    }
}

TEST_CASE("delay budget: a CiA 402 setpoint waits for the next SYNC, a sample for the next tick")
{
    CHECK(delay_budget_of(load_rig("ess-cia402")).wait_ms == doctest::Approx(2.5));
    CHECK(delay_budget_of(load_rig("ess", {"sensor.delay_ms=1"})).wait_ms == doctest::Approx(1.5));
}

} // namespace berth
