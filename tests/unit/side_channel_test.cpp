#include <doctest/doctest.h>

#include "firmware/can/codec.h"
#include "firmware/robot_channel.h"
#include "tick_builder.h"

namespace
{

constexpr std::int64_t tick_ns = 2500000;

/* The robot's channel with the axes y and rz beside that of the loop. */
struct two_sides {
    app_config config = config_default();
    struct reception reception {
    };
    struct supervisor supervisor {
    };
    struct robot_channel channel {
    };
    hal_tick tick{};
    tick_output out{};

    two_sides()
    {
        config.arm.kind = ARM_PLANAR;
        config.side_axes[SIDE_AXIS_Y].enabled = config.side_axes[SIDE_AXIS_RZ].enabled = 1;
        reception_start(&reception, &config);
        robot_channel_start(&channel, &config);
        supervisor_start(&supervisor);
    }
    void hear(std::uint32_t id, double position, std::uint8_t counter, std::int64_t now_ns, bool fault = false)
    {
        hal_frame frame = bench::feedback_frame(position, counter, now_ns, fault);
        frame.id = id;
        const received_message message = reception_check(&reception, &frame);
        REQUIRE(message != RECEIVED_NONE);
        REQUIRE(robot_channel_receive(&channel, message, &frame));
        reception_accept(&reception, message, &frame);
    }
    bool is_fresh(std::int64_t now_ns)
    {
        robot_channel_end_receive(&channel, &reception, now_ns);
        return channel.is_fresh != 0;
    }
    void send(supervisor_state state, double y_m, double rz_rad)
    {
        supervisor.state = state;
        out.frame_count = 0;
        tick.index = 1; /* without a status */
        const robot_command command{0.25, 0, 0, 0, 0, 1, {y_m, 7.0, 7.0, 7.0, rz_rad}};
        robot_channel_send(&channel, &supervisor, &tick, &command, &out);
    }
};

} // namespace

TEST_CASE("side axes: the robot's feedback is fresh when every axis has been heard of, and while it is")
{
    two_sides robot;
    robot.hear(BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID, 0.1, 1, 0);
    CHECK(!robot.is_fresh(0));
    robot.hear(BERTH_CAN_FEEDBACK_Y_FRAME_ID, 0.2, 1, 0);
    CHECK(!robot.is_fresh(0));
    robot.hear(BERTH_CAN_FEEDBACK_RZ_FRAME_ID, -0.3, 1, 0);
    CHECK(robot.is_fresh(0));
    CHECK(robot.channel.position_m == doctest::Approx(0.1));
    CHECK(robot.channel.side_position[SIDE_AXIS_Y] == doctest::Approx(0.2));
    CHECK(robot.channel.side_position[SIDE_AXIS_RZ] == doctest::Approx(-0.3));
    const std::int64_t later_ns = ns_from_ms(robot.config.robot_channel.stale_after_ms) + tick_ns;
    robot.hear(BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID, 0.1, 2, later_ns);
    robot.hear(BERTH_CAN_FEEDBACK_Y_FRAME_ID, 0.2, 2, later_ns);
    CHECK(!robot.is_fresh(later_ns));
}

TEST_CASE("side axes: a fault that one axis reports is the robot's")
{
    two_sides robot;
    robot_channel_begin_tick(&robot.channel);
    robot.hear(BERTH_CAN_FEEDBACK_RZ_FRAME_ID, 0.0, 1, 0, true);
    robot.hear(BERTH_CAN_FEEDBACK_Y_FRAME_ID, 0.0, 1, 0);
    robot.hear(BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID, 0.0, 1, 0);
    CHECK(robot.channel.fault);
}

TEST_CASE("side axes: each has its setpoint where the loop's has one, and what it carries is known")
{
    two_sides robot;
    robot.send(SUPERVISOR_START, 0.1, 0.2);
    CHECK(robot.out.frame_count == 0);
    robot.send(SUPERVISOR_RUNNING, 1.0 / 3.0, -9.0);
    REQUIRE(robot.out.frame_count == 3);
    CHECK(robot.out.frames[0].id == BERTH_CAN_SETPOINT_FRAME_ID);
    CHECK(robot.out.frames[1].id == BERTH_CAN_SETPOINT_Y_FRAME_ID);
    CHECK(robot.out.frames[2].id == BERTH_CAN_SETPOINT_RZ_FRAME_ID);
    berth_can_setpoint_y_t y{};
    berth_can_setpoint_rz_t rz{};
    REQUIRE(berth_can_setpoint_y_unpack(&y, robot.out.frames[1].data, 8) == 0);
    REQUIRE(berth_can_setpoint_rz_unpack(&rz, robot.out.frames[2].data, 8) == 0);
    CHECK(berth_can_setpoint_y_position_m_decode(y.position_m) == robot.channel.side_sent[SIDE_AXIS_Y]);
    CHECK(robot.channel.side_sent[SIDE_AXIS_Y] == doctest::Approx(1.0 / 3.0).epsilon(1e-11));
    CHECK(berth_can_setpoint_rz_angle_rad_decode(rz.angle_rad) == doctest::Approx(-CAN_POSITION_MAX_m));
    CHECK(robot.channel.saturated_setpoints == 1);
    CHECK(y.motion_allowed == 1);
}
