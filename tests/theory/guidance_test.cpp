#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

#include "firmware/arm/guidance.h"
#include "hal/rig/arm_file.h"

using namespace berth;

namespace
{

constexpr double tick_s = 2.5e-3;
const plane::vector x_axis(1.0, 0.0);

arm_order joint_order(arm_order_kind kind, int joint, double rate_rad_per_s, double angle_rad = 0.0)
{
    return {kind, joint, rate_rad_per_s, angle_rad, {}, 0.0};
}

arm_order line_order(double x_m, double y_m, double speed_m_per_s)
{
    return {ARM_ORDER_LINE, 0, 0.0, 0.0, {x_m, y_m, 0.0}, speed_m_per_s};
}

/* The planar two-link arm of the program, led with the operator at 0. */
struct led_arm {
    arm_config config = load_arm("ess").config;
    chain<plane> body = make_chain<plane>(config);
    guidance<plane> guide = guidance_at(body, joint_vector(state_at_start<plane>(config).motor_rad()));
    double fastest_rad_per_s = 0.0;
    double hardest_rad_per_s2 = 0.0;
    uint32_t limited_by = 0;

    plane::vector tool() const { return tool_in_base(body, pose_of(body, guide.motor_rad)).origin_m; }
    void take(const arm_order &order) { guidance_take(guide, body, order, x_axis, 0.0); }
    void step(double operator_m = 0.0, double operator_m_per_s = 0.0)
    {
        const joint_vector before = guide.motor_rad_per_s;
        guidance_step(guide, body, config, tick_s, x_axis, operator_m, operator_m_per_s);
        fastest_rad_per_s = std::max(fastest_rad_per_s, guide.motor_rad_per_s.cwiseAbs().maxCoeff());
        hardest_rad_per_s2 =
            std::max(hardest_rad_per_s2, (guide.motor_rad_per_s - before).cwiseAbs().maxCoeff() / tick_s);
        limited_by |= guide.active;
    }
    void run(double duration_s)
    {
        for (int i = 0; i < std::lround(duration_s / tick_s); i++) {
            step();
        }
    }
};

} // namespace

TEST_CASE("guidance: the tool follows the operator along the direction, and nowhere else")
{
    led_arm arm;
    const plane::vector home = arm.tool();
    double along_m = 0.0;
    double across_m = 0.0;
    constexpr double w = 2.0 * M_PI * 0.2;
    for (int i = 0; i < 8000; i++) {
        const double t = i * tick_s;
        const plane::vector gone = arm.tool() - home;
        if (i > 2000) { /* it starts with a jump of the velocity */
            /* The motors stand where the operator was a tick ago. */
            along_m = std::max(along_m, std::abs(gone(0) - 0.02 * std::sin(w * (t - tick_s))));
            across_m = std::max(across_m, std::abs(gone(1)));
        }
        arm.step(0.02 * std::sin(w * t), 0.02 * w * std::cos(w * t));
    }
    CHECK(along_m < 1e-4); /* a period of its fastest way is 6e-5 */
    CHECK(across_m < 1e-6);
}

TEST_CASE("guidance: a line is straight, no faster than ordered, and ends where it should")
{
    led_arm arm;
    const plane::vector from = arm.tool();
    const plane::vector way(-0.8, 0.6);
    arm.take(line_order(way(0), way(1), 0.05));
    double beside_m = 0.0;
    double fastest_m_per_s = 0.0;
    for (int i = 0; i < 12000; i++) {
        const plane::vector before = arm.tool();
        arm.step();
        const plane::vector gone = arm.tool() - from;
        fastest_m_per_s = std::max(fastest_m_per_s, (arm.tool() - before).norm() / tick_s);
        beside_m = std::max(beside_m, std::abs(gone(0) * way(1) - gone(1) * way(0)) / way.norm());
    }
    CHECK((arm.tool() - from - way).norm() < 1e-6);
    CHECK(beside_m < 1e-5);
    CHECK(fastest_m_per_s < 0.05 * 1.001);
    /* 1 m at 0.05 m/s with a second of ramp at each end: 21 s. */
    CHECK(arm.guide.line_m_per_s == doctest::Approx(0.0).epsilon(1e-6));
    CHECK(arm.limited_by == 0);
}

TEST_CASE("guidance: a joint's move takes the time that rate and acceleration leave, and ends at its angle")
{
    led_arm arm;
    const double from_rad = arm.guide.motor_rad(1);
    arm.take(joint_order(ARM_ORDER_JOINT_MOVE, 1, 0.05, from_rad + 0.2));
    double largest_rad = -10.0;
    int ticks = 0;
    while (std::abs(arm.guide.motor_rad(1) - from_rad - 0.2) > 1e-9 && ticks < 40000) {
        arm.step();
        largest_rad = std::max(largest_rad, arm.guide.motor_rad(1));
        ticks++;
    }
    const joint_vector first = joint_vector(state_at_start<plane>(arm.config).motor_rad());
    CHECK(arm.guide.motor_rad(0) == first(0));
    CHECK(largest_rad <= from_rad + 0.2 + 1e-12);
    CHECK(arm.fastest_rad_per_s <= 0.05 * (1.0 + 1e-12));
    CHECK(arm.hardest_rad_per_s2 <= arm.config.joints[1].acceleration_limit_rad_per_s2 * (1.0 + 1e-9));
    /* s / v + v / a, and two periods */
    CHECK(ticks * tick_s == doctest::Approx(0.2 / 0.05 + 0.05 / 0.2).epsilon(0.003));
}

TEST_CASE("guidance: joints turn at their own rates at once, and one order does not end another's")
{
    led_arm arm;
    const joint_vector from = arm.guide.motor_rad;
    arm.take(joint_order(ARM_ORDER_JOINT_RATE, 0, 0.02));
    arm.take(joint_order(ARM_ORDER_JOINT_RATE, 1, -0.03));
    arm.run(5.0);
    CHECK(arm.guide.motor_rad_per_s(0) == doctest::Approx(0.02));
    CHECK(arm.guide.motor_rad_per_s(1) == doctest::Approx(-0.03));
    arm.take(joint_order(ARM_ORDER_JOINT_RATE, 1, 0.0));
    arm.run(1.0);
    CHECK(arm.guide.motor_rad_per_s(0) == doctest::Approx(0.02));
    CHECK(arm.guide.motor_rad_per_s(1) == doctest::Approx(0.0));
    CHECK(arm.guide.motor_rad(0) - from(0) == doctest::Approx(0.02 * 6.0).epsilon(0.02));
    /* Following again goes on from here. */
    const plane::vector at = arm.tool();
    arm.take(joint_order(ARM_ORDER_FOLLOW, 0, 0.0));
    arm.run(5.0);
    CHECK((arm.tool() - at).norm() < 2e-3); /* the joint had to stop */
}

TEST_CASE("guidance: beyond its reach the tool falls behind, the joints stay slow, and it comes back onto the line")
{
    led_arm arm;
    const plane::vector from = arm.tool();
    arm.take(line_order(4.0, 0.0, 0.2)); /* the arm is 8 m long; this is 10.6 m from the shoulder */
    arm.run(40.0);
    CHECK((arm.limited_by & GUIDANCE_SINGULAR) != 0);
    CHECK(arm.guide.motor_rad.allFinite());
    CHECK(arm.fastest_rad_per_s <= 0.1 * (1.0 + 1e-12));
    const plane::vector shoulder(1.2, 0.6);
    CHECK((arm.tool() - shoulder).norm() <= 8.0);
    arm.take(line_order(-3.0, 0.0, 0.1));
    arm.run(60.0);
    arm.limited_by = 0;
    arm.run(1.0);
    CHECK((arm.limited_by & GUIDANCE_SINGULAR) == 0);
    CHECK(arm.tool()(0) < from(0) + 2.0);
}

TEST_CASE("guidance: a tool that cannot follow its line any further stops on it")
{
    for (const plane::vector &way_m : {plane::vector(6.4, -2.0), plane::vector(2.0, 4.0), plane::vector(4.0, 0.0)}) {
        const double goal_x_m = way_m(0);
        CAPTURE(goal_x_m);
        led_arm arm;
        const plane::vector from = arm.tool();
        const plane::vector along = way_m.normalized();
        arm.take(line_order(way_m(0), way_m(1), 0.3));
        double across_m = 0.0;
        for (int i = 0; i < 24000; i++) {
            arm.step();
            const plane::vector way = arm.tool() - from;
            across_m = std::max(across_m, (way - along * along.dot(way)).norm());
        }
        CHECK(across_m < 0.04); /* as far as the line's point is ahead of the tool */
        CHECK((arm.tool() - plane::vector(1.2, 0.6)).norm() > 7.95);
    }
}

TEST_CASE("guidance: no joint passes the end of its range, and the others go on")
{
    led_arm arm;
    arm.config.joints[1].angle_max_rad = arm.guide.motor_rad(1) + 0.05;
    arm.take(joint_order(ARM_ORDER_JOINT_RATE, 1, 0.05));
    arm.take(joint_order(ARM_ORDER_JOINT_RATE, 0, 0.01));
    arm.run(4.0);
    CHECK(arm.guide.motor_rad(1) <= arm.config.joints[1].angle_max_rad);
    CHECK(arm.guide.motor_rad(1) == doctest::Approx(arm.config.joints[1].angle_max_rad));
    CHECK((arm.limited_by & GUIDANCE_ANGLE) != 0);
    CHECK(arm.guide.motor_rad_per_s(0) == doctest::Approx(0.01));
}

/* From v the way to rest is v^2 / (2 a), and half a tick's way more for braking in ticks. */
TEST_CASE("guidance: a joint that is ordered beyond its range brakes ahead and comes to rest at its end")
{
    for (const double rate : {0.05, -0.0312345, 0.0999}) {
        CAPTURE(rate);
        led_arm arm;
        arm_joint &joint = arm.config.joints[1];
        const double a = joint.acceleration_limit_rad_per_s2;
        const double end_rad = arm.guide.motor_rad(1) + (rate > 0.0 ? 0.0712345 : -0.0712345);
        (rate > 0.0 ? joint.angle_max_rad : joint.angle_min_rad) = end_rad;
        arm.take(joint_order(ARM_ORDER_JOINT_RATE, 1, rate));
        double brakes_from_rad = 0.0;
        for (int i = 0; i < 4000; i++) {
            arm.step();
            CHECK((arm.guide.motor_rad(1) - end_rad) * rate <= 1e-12);
            if (brakes_from_rad == 0.0 && (arm.limited_by & GUIDANCE_ANGLE) != 0) {
                brakes_from_rad = arm.guide.motor_rad(1);
            }
        }
        CHECK(arm.hardest_rad_per_s2 <= a * (1.0 + 1e-9));
        CHECK(arm.fastest_rad_per_s == doctest::Approx(std::abs(rate)));
        CHECK(std::abs(end_rad - brakes_from_rad) ==
              doctest::Approx(rate * rate / (2.0 * a)).epsilon(2.0 * a * tick_s / std::abs(rate)));
        CHECK(std::abs(arm.guide.motor_rad(1) - end_rad) < 1e-12);
        CHECK(std::abs(arm.guide.motor_rad_per_s(1)) < 1e-12);
    }
}

TEST_CASE("guidance: a move ends at its angle without passing it, wherever that lies between two ticks' ways")
{
    for (int i = 0; i < 50; i++) {
        CAPTURE(i);
        led_arm arm;
        const double to_rad = arm.guide.motor_rad(1) + 0.01 + 1.7e-6 * i;
        arm.config.joints[1].angle_max_rad = to_rad;
        arm.take(joint_order(ARM_ORDER_JOINT_MOVE, 1, 0.0, to_rad));
        double largest_rad = -10.0;
        for (int tick = 0; tick < 1000; tick++) {
            arm.step();
            largest_rad = std::max(largest_rad, arm.guide.motor_rad(1));
        }
        CHECK(largest_rad <= to_rad + 1e-12);
        CHECK(std::abs(arm.guide.motor_rad(1) - to_rad) < 1e-12);
        CHECK(arm.hardest_rad_per_s2 <= arm.config.joints[1].acceleration_limit_rad_per_s2 * (1.0 + 1e-9));
        CHECK((arm.limited_by & GUIDANCE_ANGLE) == 0);
    }
}

/* All joints change their rates by one factor: one that turns round must not keep the other from braking. */
TEST_CASE("guidance: a joint stops at its end of range while a line asks much of the other")
{
    led_arm arm;
    arm.config.joints[1].angle_max_rad = arm.guide.motor_rad(1) + 0.05;
    arm.take(line_order(1.5, 0.5, 0.3));
    bool is_turned = false;
    for (int i = 0; i < 8000; i++) {
        arm.step();
        CHECK(arm.guide.motor_rad(1) <= arm.config.joints[1].angle_max_rad + 1e-12);
        if (!is_turned && (arm.limited_by & GUIDANCE_ANGLE) != 0) {
            is_turned = true;
            arm.take(line_order(1.5, -1.5, 0.3));
        }
    }
    CHECK(is_turned);
    CHECK(arm.hardest_rad_per_s2 <= arm.config.joints[0].acceleration_limit_rad_per_s2 * (1.0 + 1e-9));
}

TEST_CASE("guidance: dexterity is the least pivot of J J^T; a stretched arm has none")
{
    led_arm arm;
    arm.guide.motor_rad(1) = 0.0;
    CHECK(guidance_dexterity(arm.body, arm.guide.motor_rad) < 1e-12);
    arm.guide.motor_rad(1) = M_PI / 2.0;
    /* Links of half the reach at a right angle, the first along x: J = [[-1/2, -1/2], [1/2, 0]] in the axes of the
     * first link, J J^T = [[1/2, -1/4], [-1/4, 1/4]], pivots 1/2 and 1/8. */
    arm.guide.motor_rad(0) = 0.0;
    CHECK(guidance_dexterity(arm.body, arm.guide.motor_rad) == doctest::Approx(0.125));
}

/* A move counts on all of its joint's braking, whatever the other is told meanwhile. */
TEST_CASE("guidance: what one joint is ordered keeps no other from ending its move at its angle")
{
    for (int i = 0; i < 60; i++) {
        CAPTURE(i);
        led_arm arm;
        const double to_rad = arm.guide.motor_rad(1) - 0.3;
        arm.take(joint_order(ARM_ORDER_JOINT_RATE, 0, 0.1));
        arm.take(joint_order(ARM_ORDER_JOINT_MOVE, 1, 0.0, to_rad));
        double least_rad = 10.0;
        for (int tick = 0; tick < 3000; tick++) {
            if (tick == 20 * i) {
                arm.take(joint_order(ARM_ORDER_JOINT_RATE, 0, -0.1));
            }
            arm.step();
            least_rad = std::min(least_rad, arm.guide.motor_rad(1));
        }
        CHECK(least_rad >= to_rad - 1e-12);
        CHECK(std::abs(arm.guide.motor_rad(1) - to_rad) < 1e-12);
        CHECK(arm.guide.motor_rad_per_s(0) == doctest::Approx(-0.1));
        CHECK(arm.hardest_rad_per_s2 <= arm.config.joints[0].acceleration_limit_rad_per_s2 * (1.0 + 1e-9));
        CHECK(arm.fastest_rad_per_s <= 0.1 * (1.0 + 1e-12));
    }
}

TEST_CASE("guidance: a joint that is ordered on while it rests at its end of range slows no other")
{
    for (const double into : {0.05, 8.3}) {
        CAPTURE(into);
        led_arm arm;
        arm.config.joints[0].angle_max_rad = arm.guide.motor_rad(0) + 0.02;
        arm.take(joint_order(ARM_ORDER_JOINT_RATE, 0, into));
        arm.run(2.0);
        CHECK(arm.guide.motor_rad(0) == doctest::Approx(arm.config.joints[0].angle_max_rad));
        const double to_rad = arm.guide.motor_rad(1) + 0.2;
        arm.take(joint_order(ARM_ORDER_JOINT_MOVE, 1, 0.05, to_rad));
        int ticks = 0;
        while (std::abs(arm.guide.motor_rad(1) - to_rad) > 1e-9 && ticks < 40000) {
            arm.step();
            ticks++;
        }
        /* s / v + v / a, and two periods: the same as alone */
        CHECK(ticks * tick_s == doctest::Approx(0.2 / 0.05 + 0.05 / 0.2).epsilon(0.003));
        CHECK(arm.guide.motor_rad(0) <= arm.config.joints[0].angle_max_rad + 1e-12);
    }
}
