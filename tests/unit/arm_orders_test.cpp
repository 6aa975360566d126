#include <doctest/doctest.h>

#include "firmware/operator_command.h"
#include "tests/support/one_joint_arm.h"
#include "tick_builder.h"

namespace
{

/* An arm with one joint, from -1 to 2 rad. */
struct one_joint_channel {
    app_config config = config_default();
    operator_channel channel{};
    arm_order order{};

    one_joint_channel()
    {
        config.arm = one_joint_arm();
        config.arm.joints[0].angle_min_rad = -1.0;
        config.arm.joints[0].angle_max_rad = 2.0;
        operator_channel_start(&channel, &config);
    }
    bool takes(received_message message, const hal_frame &frame)
    {
        return operator_channel_receive_order(&channel, message, &frame, &order) != 0;
    }
    bool takes_joint(int joint, int kind, double rate_rad_per_s, double angle_rad)
    {
        return takes(RECEIVED_OPERATOR_JOINT, bench::joint_frame(joint, kind, rate_rad_per_s, angle_rad, 1));
    }
};

constexpr int rate = BERTH_CAN_OPERATOR_JOINT_ORDER_RATE_CHOICE;
constexpr int move = BERTH_CAN_OPERATOR_JOINT_ORDER_MOVE_CHOICE;
constexpr int follow = BERTH_CAN_OPERATOR_JOINT_ORDER_FOLLOW_CHOICE;

} // namespace

TEST_CASE("orders: what a frame says is what is ordered")
{
    one_joint_channel arm;
    CHECK(arm.takes_joint(0, rate, -0.25, 0.0));
    CHECK(arm.order.kind == ARM_ORDER_JOINT_RATE);
    CHECK(arm.order.rate_rad_per_s == doctest::Approx(-0.25));
    CHECK(arm.takes_joint(0, move, 0.1, 1.5));
    CHECK(arm.order.kind == ARM_ORDER_JOINT_MOVE);
    CHECK(arm.order.angle_rad == doctest::Approx(1.5));
    CHECK(arm.takes_joint(0, follow, 0.0, 0.0));
    CHECK(arm.order.kind == ARM_ORDER_FOLLOW);
    CHECK(arm.takes(RECEIVED_OPERATOR_LINE, bench::line_frame(0.3, -0.2, 0.05, 1)));
    CHECK(arm.order.kind == ARM_ORDER_LINE);
    CHECK(arm.order.way_m[0] == doctest::Approx(0.3));
    CHECK(arm.order.way_m[1] == doctest::Approx(-0.2));
    CHECK(arm.order.way_m[2] == 0.0);
    CHECK(arm.order.speed_m_per_s == doctest::Approx(0.05));
}

TEST_CASE("orders: a joint, an angle or a speed that there is not is rejected")
{
    one_joint_channel arm;
    CHECK(!arm.takes_joint(1, rate, 0.1, 0.0));
    CHECK(!arm.takes_joint(0, 3, 0.1, 0.0));
    CHECK(!arm.takes_joint(0, move, 0.1, 2.1));
    CHECK(!arm.takes_joint(0, move, 0.1, -1.1));
    CHECK(!arm.takes_joint(0, move, -0.1, 0.5));
    CHECK(!arm.takes(RECEIVED_OPERATOR_LINE, bench::line_frame(0.3, 0.0, 0.0, 1)));
    hal_frame cut = bench::line_frame(0.3, 0.0, 0.1, 1);
    cut.length = 7;
    CHECK(!arm.takes(RECEIVED_OPERATOR_LINE, cut));
}
