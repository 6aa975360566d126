#include <cmath>
#include <doctest/doctest.h>
#include <Eigen/Geometry>
#include <memory>
#include <random>

#include "firmware/arm/robot_frame.h"
#include "firmware/energy_account.h"
#include "firmware/side_axes.h"
#include "hal/rig/wrench_matrix.h"
#include "tests/support/one_joint_arm.h"

using namespace berth;

namespace
{

/* One joint whose motor is as good as fixed: its turn is a mass of 200 on a spring, in rad and N m. */
app_config turning_loop()
{
    app_config config = config_default();
    config.manipulator.mass_kg = one_joint::inertia;
    config.manipulator.stiffness_N_per_m = one_joint::stiffness;
    config.manipulator.damping_N_s_per_m = one_joint::damping;
    config.arm = one_joint_arm();
    arm_joint &joint = config.arm.joints[0];
    joint.link.inertia_kg_m2[5] = one_joint::inertia;
    joint.stiffness_N_m_per_rad = one_joint::stiffness;
    joint.damping_N_m_s_per_rad = one_joint::damping;
    joint.rotor_inertia_kg_m2 = 1e12;
    config.side_axes[SIDE_AXIS_RZ].enabled = 1;
    config.side_axes[SIDE_AXIS_Y].enabled = 1;
    return config;
}

Eigen::Vector3d random_vector(std::mt19937 &random)
{
    std::normal_distribution<double> normal;
    return {normal(random), normal(random), normal(random)};
}

} // namespace

TEST_CASE("side axes: a torque on the tool turns it as a force pushes the manipulator of one degree of freedom")
{
    app_config with_arm = turning_loop();
    with_arm.arm.force = ARM_FORCE_HELD; /* as the manipulator of one degree of freedom takes it */
    app_config plain = with_arm;
    plain.arm.kind = ARM_NONE;
    const auto arm = std::make_unique<manipulator>();
    const auto mass = std::make_unique<manipulator>();
    manipulator_start(arm.get(), &with_arm);
    manipulator_start(mass.get(), &plain);
    const operator_command rest{};
    double swing = 0.0;
    double error = 0.0;
    double way_error_m = 0.0;
    for (int i = 0; i < 800; i++) {
        const double load = 20.0 * std::sin(0.02 * i);
        const double loads[SIDE_AXIS_COUNT] = {0.0, 0.0, 0.0, 0.0, load};
        manipulator_load_sides(arm.get(), loads);
        manipulator_step(arm.get(), &rest, 0.0);
        manipulator_step(mass.get(), &rest, load);
        double side[SIDE_AXIS_COUNT];
        manipulator_sides(arm.get(), side);
        swing = std::max(swing, std::abs(mass->position_m));
        error = std::max(error, std::abs(side[SIDE_AXIS_RZ] - mass->position_m));
        way_error_m = std::max(way_error_m, std::abs(side[SIDE_AXIS_Y] - std::sin(side[SIDE_AXIS_RZ])));
    }
    CHECK(swing > 1e-3);
    CHECK(error < 2e-4 * swing); /* (w h)^2 / 12 of a swing, two seconds long */
    CHECK(way_error_m < 1e-14);  /* the tool is a metre out */
}

TEST_CASE("side axes: a force beside the direction turns the joint by its lever")
{
    const app_config config = turning_loop();
    const auto by_force = std::make_unique<manipulator>();
    const auto by_torque = std::make_unique<manipulator>();
    manipulator_start(by_force.get(), &config);
    manipulator_start(by_torque.get(), &config);
    const operator_command rest{};
    for (int i = 0; i < 400; i++) {
        const double force_N = 10.0 * std::sin(0.03 * i);
        double side[SIDE_AXIS_COUNT];
        manipulator_sides(by_force.get(), side);
        const double forces[SIDE_AXIS_COUNT] = {force_N, 0.0, 0.0, 0.0, 0.0};
        const double torques[SIDE_AXIS_COUNT] = {0.0, 0.0, 0.0, 0.0, force_N * std::cos(side[SIDE_AXIS_RZ])};
        manipulator_load_sides(by_force.get(), forces);
        manipulator_load_sides(by_torque.get(), torques);
        manipulator_step(by_force.get(), &rest, 0.0);
        manipulator_step(by_torque.get(), &rest, 0.0);
    }
    double forced[SIDE_AXIS_COUNT];
    double turned[SIDE_AXIS_COUNT];
    manipulator_sides(by_force.get(), forced);
    manipulator_sides(by_torque.get(), turned);
    CHECK(std::abs(turned[SIDE_AXIS_RZ]) > 1e-4);
    CHECK(forced[SIDE_AXIS_RZ] == doctest::Approx(turned[SIDE_AXIS_RZ]).epsilon(1e-6));
}

TEST_CASE("side axes: the energy account books what goes through them")
{
    app_config config = turning_loop();
    config.arm.joints[0].damping_N_m_s_per_rad = 0.0;
    double lead_ticks = 0.0;
    SUBCASE("held")
    {
        config.arm.force = ARM_FORCE_HELD;
    }
    SUBCASE("led")
    {
        config.arm.force = ARM_FORCE_LED;
        lead_ticks = 0.5;
    }
    const auto arm = std::make_unique<manipulator>();
    manipulator_start(arm.get(), &config);
    const auto account = std::make_unique<energy_account>();
    energy_account_start(account.get(), &config, arm.get());
    const operator_command rest{};
    double given_J = 0.0;
    double load_before = 0.0;
    for (int i = 0; i < 4000; i++) {
        double before[SIDE_AXIS_COUNT];
        manipulator_sides(arm.get(), before);
        const double load = 50.0 * std::sin(0.015 * i);
        energy_sides sides{};
        sides.force[SIDE_AXIS_RZ] = load;
        sides.position[SIDE_AXIS_RZ] = before[SIDE_AXIS_RZ];
        energy_account_sides(account.get(), &sides);
        manipulator_load_sides(arm.get(), sides.force);
        energy_account_book(account.get(), &rest, 0.0, 0.0, 0.0, 1);
        energy_account_announce(account.get(), &rest, 0.0, 0.0, 1);
        manipulator_step(arm.get(), &rest, 0.0);
        double after[SIDE_AXIS_COUNT];
        manipulator_sides(arm.get(), after);
        const double acting = load + lead_ticks * (load - load_before);
        given_J += i < 3999 ? acting * (after[SIDE_AXIS_RZ] - before[SIDE_AXIS_RZ]) : 0.0;
        load_before = load;
    }
    CHECK(std::abs(given_J) > 0.01);
    CHECK(account->sums.simulated_port_J == doctest::Approx(given_J).epsilon(1e-9));
    CHECK(account->sums.stored_J == doctest::Approx(-given_J).epsilon(1e-6));
    CHECK(std::abs(account->sums.operator_J) < 1e-6 * std::abs(given_J) + 1e-9);
}

TEST_CASE("side axes: a rotation vector is Eigen's axis times angle, and leads back to its rotation")
{
    std::mt19937 random(20261);
    for (int i = 0; i < 2000; i++) {
        const Eigen::Vector3d axis = random_vector(random).normalized();
        const double angle_rad = i < 20 ? std::pow(10.0, -i) : 3.1 * std::uniform_real_distribution<>()(random);
        const space::rotation rotation = Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix();
        CHECK((rotation_vector(rotation) - angle_rad * axis).norm() < 2e-14 / (3.1416 - angle_rad));
        CHECK((rotation_by(angle_rad * axis) - rotation).norm() < 4e-15);
    }
    CHECK(rotation_vector(space::rotation::Identity()).norm() == 0.0);
}

TEST_CASE("side axes: the robot's frame is right-handed, along the direction, with z up")
{
    std::mt19937 random(20262);
    for (int i = 0; i < 500; i++) {
        const Eigen::Vector3d x =
            i == 0 ? Eigen::Vector3d(Eigen::Vector3d::UnitZ()) : random_vector(random).normalized();
        const auto frame = robot_frame<space>::with_x_along(x);
        CHECK((frame.axes.transpose() * frame.axes - Eigen::Matrix3d::Identity()).norm() < 1e-14);
        CHECK(frame.axes.determinant() == doctest::Approx(1.0));
        CHECK((frame.axes.col(0) - x).norm() == 0.0);
        CHECK(frame.axes.col(2)(std::abs(x(2)) < 0.9 ? 2 : 1) > 0.0);
    }
}

TEST_CASE("side axes: a pose that is called something is shown as that, and moves on from there")
{
    std::mt19937 random(20263);
    for (int i = 0; i < 200; i++) {
        auto frame = robot_frame<space>::with_x_along(random_vector(random).normalized());
        const Eigen::Vector3d origin_m = random_vector(random);
        const space::rotation turned = rotation_by(0.5 * random_vector(random));
        const double called[SIDE_AXIS_COUNT] = {0.3, -0.2, 0.4, -0.5, 0.6};
        frame.call(origin_m, turned, called);
        double shown[SIDE_AXIS_COUNT];
        frame.show(origin_m, turned, shown);
        for (int axis = 0; axis < SIDE_AXIS_COUNT; axis++) {
            CHECK(shown[axis] == doctest::Approx(called[axis]).epsilon(1e-12));
        }
        const double nowhere[SIDE_AXIS_COUNT] = {};
        frame.call(origin_m, turned, nowhere);
        const Eigen::Vector3d turn = frame.axes * Eigen::Vector3d(0.1, 0.2, -0.3);
        frame.show(origin_m + frame.axes * Eigen::Vector3d(7.0, 0.5, -0.25), rotation_by(turn) * turned, shown);
        const double moved[SIDE_AXIS_COUNT] = {0.5, -0.25, 0.1, 0.2, -0.3};
        for (int axis = 0; axis < SIDE_AXIS_COUNT; axis++) {
            CHECK(shown[axis] == doctest::Approx(moved[axis]).epsilon(1e-12));
        }
    }
}

/* Work does not depend on where and in which axes a wrench is told: force . velocity + torque . turn rate. */
TEST_CASE("wrench: mounted anywhere, a sensor measures the same work")
{
    std::mt19937 random(20264);
    for (int i = 0; i < 200; i++) {
        wrench_rig mounted;
        const Eigen::Vector3d angles_rad = random_vector(random);
        const Eigen::Vector3d origin_m = random_vector(random);
        for (std::size_t k = 0; k < 3; k++) {
            mounted.angles_rad[k] = angles_rad(static_cast<Eigen::Index>(k));
            mounted.origin_m[k] = origin_m(static_cast<Eigen::Index>(k));
        }
        const wrench_matrix matrix = shown_wrench(mounted);
        const Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>> shown(matrix.data());
        Eigen::Matrix<double, 6, 1> load;
        load << random_vector(random), random_vector(random);
        const Eigen::Vector3d velocity = random_vector(random);
        const Eigen::Vector3d rate = random_vector(random);
        const Eigen::Matrix3d axes = (Eigen::AngleAxisd(angles_rad(2), Eigen::Vector3d::UnitZ()) *
                                      Eigen::AngleAxisd(angles_rad(1), Eigen::Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(angles_rad(0), Eigen::Vector3d::UnitX()))
                                         .toRotationMatrix();
        Eigen::Matrix<double, 6, 1> motion_there;
        motion_there << axes.transpose() * (velocity + rate.cross(origin_m)), axes.transpose() * rate;
        const double work = load.head<3>().dot(velocity) + load.tail<3>().dot(rate);
        CHECK((shown * load).dot(motion_there) == doctest::Approx(work).epsilon(1e-12));
    }
}

TEST_CASE("side axes: every axis keeps its own limits, and one that there is not stays at 0")
{
    app_config config = config_default();
    for (int axis = 0; axis < SIDE_AXIS_COUNT; axis++) {
        config.side_axes[axis] = {axis != SIDE_AXIS_RX, 0.002, {-0.1 * (axis + 1), 0.1 * (axis + 1), 0.5, 20.0}};
    }
    side_axes axes{};
    side_axes_start(&axes, &config);
    CHECK(axes.any);
    double permitted[SIDE_AXIS_COUNT];
    double before[SIDE_AXIS_COUNT] = {};
    const double wanted[SIDE_AXIS_COUNT] = {9.0, 0.15, 9.0, -9.0, std::nan("")};
    for (int i = 0; i < 2000; i++) {
        side_axes_limit(&axes, wanted, permitted);
        for (int axis = 0; axis < SIDE_AXIS_COUNT; axis++) {
            CHECK(std::abs(permitted[axis] - before[axis]) <= 0.5 * 2.5e-3 * (1 + 1e-12));
            before[axis] = permitted[axis];
        }
    }
    CHECK(permitted[SIDE_AXIS_Y] == doctest::Approx(0.1));
    CHECK(permitted[SIDE_AXIS_Z] == doctest::Approx(0.15));
    CHECK(permitted[SIDE_AXIS_RX] == 0.0);
    CHECK(permitted[SIDE_AXIS_RY] == doctest::Approx(-0.4));
    CHECK(permitted[SIDE_AXIS_RZ] == 0.0);
    CHECK(axes.active == (LIMIT_POSITION | LIMIT_NOT_FINITE));
    const double near[SIDE_AXIS_COUNT] = {0.101, 0.15, 5.0, -0.4, 0.0};
    const double far[SIDE_AXIS_COUNT] = {0.103, 0.15, 5.0, -0.4, 0.0};
    CHECK(side_axes_at_place(&axes, near));
    CHECK(!side_axes_at_place(&axes, far));
}
