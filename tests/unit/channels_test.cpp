/* The channels that read frames: operator command, force sensor, robot feedback. */
#include <doctest/doctest.h>

#include "firmware/operator_command.h"
#include "firmware/robot_channel.h"
#include "firmware/sensor_channel.h"
#include "tick_builder.h"

namespace
{

struct operator_bench {
    app_config config = config_default();
    operator_channel channel{};

    explicit operator_bench(operator_interface interface)
    {
        config.operator_command.interface = interface;
        config.operator_command.position_limit_m = 0.5;
        config.operator_command.velocity_limit_m_per_s = 0.25;
        config.operator_command.force_limit_N = 100.0;
        operator_channel_start(&channel, &config);
    }

    bool motion(double position_m, double velocity_m_per_s, int request = OPERATOR_RUN)
    {
        const hal_frame frame = bench::motion_frame(position_m, velocity_m_per_s, request, 0);
        return operator_channel_receive(&channel, RECEIVED_OPERATOR_MOTION, &frame) != 0;
    }

    bool force(double force_N, int request = OPERATOR_RUN)
    {
        const hal_frame frame = bench::operator_force_frame(force_N, request, 0);
        return operator_channel_receive(&channel, RECEIVED_OPERATOR_FORCE, &frame) != 0;
    }
};

} // namespace

TEST_CASE("operator_command: starts at rest and without a request")
{
    const operator_bench bench(OPERATOR_INTERFACE_MOTION);
    CHECK(bench.channel.command.position_m == 0.0);
    CHECK(bench.channel.command.velocity_m_per_s == 0.0);
    CHECK(bench.channel.command.force_N == 0.0);
    CHECK(bench.channel.command.request == OPERATOR_NONE);
}

TEST_CASE("operator_command: a motion in range is taken to half a step of the frame")
{
    operator_bench bench(OPERATOR_INTERFACE_MOTION);
    CHECK(bench.motion(0.123456789123, -0.2345678, OPERATOR_HOLD));
    CHECK(std::abs(bench.channel.command.position_m - 0.123456789123) <= 0.51e-9);
    CHECK(std::abs(bench.channel.command.velocity_m_per_s + 0.2345678) <= 0.51e-6);
    CHECK(bench.channel.command.force_N == 0.0);
    CHECK(bench.channel.command.request == OPERATOR_HOLD);
    CHECK(bench.motion(0.5, 0.25));
    CHECK(bench.motion(-0.5, -0.25));
}

TEST_CASE("operator_command: a motion out of range changes nothing")
{
    operator_bench bench(OPERATOR_INTERFACE_MOTION);
    REQUIRE(bench.motion(0.1, 0.2));
    CHECK_FALSE(bench.motion(0.5 + 1e-6, 0.0, OPERATOR_HOLD));
    CHECK_FALSE(bench.motion(-0.5 - 1e-6, 0.0, OPERATOR_HOLD));
    CHECK_FALSE(bench.motion(0.0, 0.25 + 1e-5, OPERATOR_HOLD));
    CHECK_FALSE(bench.motion(0.0, -0.25 - 1e-5, OPERATOR_HOLD));
    for (int request = OPERATOR_REQUEST_COUNT; request < 16; request++) {
        CAPTURE(request);
        CHECK_FALSE(bench.motion(0.0, 0.0, request));
    }
    CHECK(bench.channel.command.position_m == doctest::Approx(0.1));
    CHECK(bench.channel.command.velocity_m_per_s == doctest::Approx(0.2));
    CHECK(bench.channel.command.request == OPERATOR_RUN);
}

TEST_CASE("operator_command: a force in range is taken, one out of range changes nothing")
{
    operator_bench bench(OPERATOR_INTERFACE_FORCE);
    CHECK(bench.force(-99.87654321));
    CHECK(std::abs(bench.channel.command.force_N + 99.87654321) <= 0.51e-7);
    CHECK(bench.channel.command.request == OPERATOR_RUN);
    CHECK_FALSE(bench.force(100.001, OPERATOR_HOLD));
    CHECK_FALSE(bench.force(-100.001, OPERATOR_HOLD));
    CHECK_FALSE(bench.force(0.0, OPERATOR_REQUEST_COUNT));
    CHECK(std::abs(bench.channel.command.force_N + 99.87654321) <= 0.51e-7);
    CHECK(bench.channel.command.request == OPERATOR_RUN);
}

TEST_CASE("operator_command: only the configured interface is listened to")
{
    operator_bench motion(OPERATOR_INTERFACE_MOTION);
    CHECK(operator_message(&motion.config.operator_command) == RECEIVED_OPERATOR_MOTION);
    CHECK_FALSE(motion.force(1.0));
    CHECK(motion.channel.command.request == OPERATOR_NONE);
    operator_bench force(OPERATOR_INTERFACE_FORCE);
    CHECK(operator_message(&force.config.operator_command) == RECEIVED_OPERATOR_FORCE);
    CHECK_FALSE(force.motion(0.1, 0.0));
    CHECK(force.channel.command.request == OPERATOR_NONE);
}

TEST_CASE("operator_command: a frame too short to unpack is refused")
{
    operator_bench bench(OPERATOR_INTERFACE_MOTION);
    hal_frame frame = bench::motion_frame(0.1, 0.0, OPERATOR_RUN, 0);
    frame.length = 7;
    CHECK(operator_channel_receive(&bench.channel, RECEIVED_OPERATOR_MOTION, &frame) == 0);
    CHECK(bench.channel.command.request == OPERATOR_NONE);
}

TEST_CASE("sensor_channel: the force, its time, saturation and the limit")
{
    app_config config = config_default();
    config.sensor_channel.force_limit_N = 500.0;
    sensor_channel channel;
    sensor_channel_start(&channel, &config);
    const auto receive = [&](double force_N, bool saturated) {
        const hal_frame frame = bench::force_frame(force_N, 0, 1234, saturated);
        sensor_channel_begin_tick(&channel);
        return sensor_channel_receive(&channel, 0, &frame) != 0;
    };
    CHECK(receive(-123.4567891, false));
    CHECK(std::abs(channel.force_N + 123.4567891) <= 0.51e-7);
    CHECK(channel.received_ns == 1234);
    CHECK(channel.saturated == 0);
    CHECK(channel.over_limit == 0);
    CHECK(receive(1.0, true));
    CHECK(channel.saturated == 1);
    CHECK(receive(1.0, false));
    CHECK(channel.saturated == 0);
    CHECK(receive(500.0, false));
    CHECK(channel.over_limit == 0);
    for (const double force_N : {500.001, -500.001, 54000.0}) {
        CAPTURE(force_N);
        CHECK(receive(force_N, false));
        CHECK(channel.over_limit == 1);
    }
}

TEST_CASE("sensor_channel: a force outside the range of the frame is refused and changes nothing")
{
    const app_config config = config_default();
    sensor_channel channel;
    sensor_channel_start(&channel, &config);
    const hal_frame good = bench::force_frame(3.0, 0, 10);
    REQUIRE(sensor_channel_receive(&channel, 0, &good));
    for (const double force_N : {54000.001, -54000.001}) {
        CAPTURE(force_N);
        const hal_frame frame = bench::force_frame(force_N, 1, 20, true);
        CHECK_FALSE(sensor_channel_receive(&channel, 0, &frame));
    }
    hal_frame cut = good;
    cut.length = 7;
    CHECK_FALSE(sensor_channel_receive(&channel, 0, &cut));
    CHECK(channel.force_N == 3.0);
    CHECK(channel.received_ns == 10);
    CHECK(channel.saturated == 0);
}

TEST_CASE("robot_channel: feedback gives position and fault; outside the range of the frame it changes nothing")
{
    const app_config config = config_default();
    robot_channel channel;
    robot_channel_start(&channel, &config);
    const auto receive = [&](double position_m, bool fault) {
        const hal_frame frame = bench::feedback_frame(position_m, 0, 0, fault);
        robot_channel_begin_tick(&channel);
        return robot_channel_receive(&channel, RECEIVED_ROBOT_FEEDBACK, &frame) != 0;
    };
    CHECK(receive(-1.23456789012, true));
    CHECK(std::abs(channel.position_m + 1.23456789012) <= 0.51e-11);
    CHECK(channel.fault == 1);
    CHECK(receive(5.4, false));
    CHECK(channel.fault == 0);
    CHECK_FALSE(receive(5.4001, true));
    CHECK_FALSE(receive(-5.4001, true));
    CHECK(channel.position_m == doctest::Approx(5.4));
    CHECK(channel.fault == 0);
}

TEST_CASE("sensor_channel, robot_channel: of several frames in one tick none hides the trouble of another")
{
    app_config config = config_default();
    config.sensor_channel.force_limit_N = 100.0;
    sensor_channel sensor;
    sensor_channel_start(&sensor, &config);
    const auto sense = [&](double force_N, bool saturated) {
        const hal_frame frame = bench::force_frame(force_N, 0, 0, saturated);
        REQUIRE(sensor_channel_receive(&sensor, 0, &frame));
    };
    sensor_channel_begin_tick(&sensor);
    sense(50.0, true);
    sense(200.0, false);
    sense(1.0, false);
    CHECK(sensor.force_N == doctest::Approx(1.0));
    CHECK(sensor.saturated);
    CHECK(sensor.over_limit);
    sensor_channel_begin_tick(&sensor);
    CHECK(sensor.saturated); /* no news */
    sense(2.0, false);
    CHECK(!sensor.saturated);
    CHECK(!sensor.over_limit);

    robot_channel robot;
    robot_channel_start(&robot, &config);
    const auto report = [&](bool fault) {
        const hal_frame frame = bench::feedback_frame(0.0, 0, 0, fault);
        REQUIRE(robot_channel_receive(&robot, RECEIVED_ROBOT_FEEDBACK, &frame));
    };
    robot_channel_begin_tick(&robot);
    report(true);
    report(false);
    CHECK(robot.fault);
    robot_channel_begin_tick(&robot);
    report(false);
    CHECK(!robot.fault);
}

TEST_CASE("sensor_channel: the count of samples may wrap around, the force stays fresh")
{
    const app_config config = config_default();
    sensor_channel channel;
    sensor_channel_start(&channel, &config);
    channel.samples = UINT32_MAX; /* 12 hours at 100 kHz */
    for (std::uint8_t counter = 0; counter < 3; counter++) {
        const hal_frame frame = bench::force_frame(1.0, counter, 1000);
        REQUIRE(sensor_channel_receive(&channel, 0, &frame) != 0);
        CHECK(sensor_channel_is_stale(&channel, 1000) == 0);
    }
    CHECK(channel.samples == 2);
}
