/* Setpoints that do not arrive, with the loop's own program around the firmware and the simulated rig. */
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "../support/closed_loop.h"

namespace berth
{

namespace
{

constexpr double ticks_a_s = 400.0;

void run_until_s(closed_loop &loop, double time_s)
{
    while (static_cast<double>(loop.app().recorder.tick.index + 1) < time_s * ticks_a_s) {
        REQUIRE(loop.tick());
    }
}

} // namespace

TEST_CASE("undelivered: frames that every bus refuses are counted and stop the loop, near where the robot is")
{
    closed_loop loop(
        "ess", {"run.duration_s=20", "profile.kind=multisine", "profile.amplitude_m=0.1", "profile.duration_s=10"});
    run_until_s(loop, 2.0);
    REQUIRE(loop.is_running());
    sim_refuse_frames(loop.hal(), true);
    run_until_s(loop, 2.1);
    CHECK(loop.app().supervisor.state == SUPERVISOR_FAULT);
    CHECK(loop.app().supervisor.stop_cause == STOP_SEND_REFUSED);
    CHECK(loop.app().recorder.tick.unsent_frames >= 38);
    CHECK(std::abs(loop.app().recorder.tick.command_position_m - loop.truth().robot_position_m) < 0.02);
    const double robot_m = loop.truth().robot_position_m;
    run_until_s(loop, 10.0);
    CHECK(loop.app().supervisor.state == SUPERVISOR_FAULT);
    CHECK(loop.truth().robot_position_m == doctest::Approx(robot_m));
}

TEST_CASE("undelivered: a bus on which nearly every frame is destroyed stops the loop within a second")
{
    closed_loop loop("ess", {"run.duration_s=120", "bus.error_probability=0.9", "profile.kind=multisine",
                             "profile.amplitude_m=0.01", "profile.duration_s=20"});
    int ticks_in_motion = 0;
    while (loop.tick()) {
        ticks_in_motion += loop.is_running();
    }
    CHECK(ticks_in_motion < ticks_a_s);
}

} // namespace berth
