#include <cmath>
#include <doctest/doctest.h>
#include <memory>

#include "firmware/energy_account.h"
#include "hal/rig/rig_file.h"
#include "tests/support/one_joint_arm.h"

namespace
{

/* One joint whose motor is as good as fixed, the tool a metre out: along y it is a mass of 200 kg on a spring. */
app_config pendulum_loop(double damping_N_m_s_per_rad)
{
    app_config config = config_default();
    config.manipulator.mass_kg = one_joint::inertia;
    config.manipulator.stiffness_N_per_m = one_joint::stiffness;
    config.manipulator.damping_N_s_per_m = damping_N_m_s_per_rad;
    config.manipulator.direction_x = 0.0;
    config.manipulator.direction_y = -2.0; /* any length; away from the turn */
    config.arm = one_joint_arm();
    arm_joint &joint = config.arm.joints[0];
    joint.link.inertia_kg_m2[5] = one_joint::inertia;
    joint.stiffness_N_m_per_rad = one_joint::stiffness;
    joint.damping_N_m_s_per_rad = damping_N_m_s_per_rad;
    joint.rotor_inertia_kg_m2 = 1e12;
    return config;
}

} // namespace

TEST_CASE("arm in the loop: for small motion a pendulum is the manipulator of one degree of freedom")
{
    app_config with_arm = pendulum_loop(one_joint::damping);
    with_arm.arm.force = ARM_FORCE_HELD; /* as the manipulator of one degree of freedom takes it */
    app_config plain = with_arm;
    plain.arm.kind = ARM_NONE;
    const auto arm = std::make_unique<manipulator>();
    const auto mass = std::make_unique<manipulator>();
    manipulator_start(arm.get(), &with_arm);
    manipulator_start(mass.get(), &plain);
    CHECK(arm->position_m == 0.0);
    const operator_command rest{};
    double swing_m = 0.0;
    double error_m = 0.0;
    for (int i = 0; i < 800; i++) {
        const double force_N = 0.1 * std::sin(0.02 * i);
        manipulator_step(arm.get(), &rest, force_N);
        manipulator_step(mass.get(), &rest, force_N);
        swing_m = std::max(swing_m, std::abs(mass->position_m));
        error_m = std::max(error_m, std::abs(arm->position_m - mass->position_m));
    }
    CHECK(swing_m > 1e-5);
    CHECK(error_m < 2e-4 * swing_m); /* (w h)^2 / 12 of a swing, two seconds long */
}

TEST_CASE("arm in the loop: without dampers all that its energy account finds goes through its port")
{
    const app_config config = pendulum_loop(0.0);
    const auto arm = std::make_unique<manipulator>();
    manipulator_start(arm.get(), &config);
    const auto account = std::make_unique<energy_account>();
    energy_account_start(account.get(), &config, arm.get());
    const operator_command rest{};
    double most_J = 0.0;
    for (int i = 0; i < 4000; i++) {
        const double force_N = 50.0 * std::sin(0.015 * i);
        energy_account_book(account.get(), &rest, force_N, 0.0, 0.0, 1);
        energy_account_announce(account.get(), &rest, force_N, force_N, 1);
        manipulator_step(arm.get(), &rest, force_N);
        most_J = std::max(most_J, account->sums.stored_J);
    }
    CHECK(most_J > 0.5);
    CHECK(std::abs(account->sums.operator_J) <
          1e-3 * most_J); /* the tool goes round, not straight: of the swing's square */
    CHECK(account->sums.stored_J == doctest::Approx(account->sums.operator_J - account->sums.simulated_port_J));
}

TEST_CASE("arm in the loop: put to rest it stands where it is told to be, and stays there")
{
    const berth::rig rig = berth::load_rig("ess", {"manipulator.arm=ess", "manipulator.initial_position_m=0"});
    const auto arm = std::make_unique<manipulator>();
    manipulator_start(arm.get(), &rig.firmware);
    operator_command command{};
    for (int i = 0; i < 2000; i++) {
        command.position_m = 1e-4 * i;
        command.velocity_m_per_s = 0.04;
        manipulator_step(arm.get(), &command, 0.0);
    }
    CHECK(arm->position_m > 0.1);
    manipulator_rest_at(arm.get(), 0.123);
    CHECK(arm->position_m == doctest::Approx(0.123).epsilon(1e-12));
    CHECK(arm->velocity_m_per_s == 0.0);
    /* The operator's 0.123 m is here, too: nothing moves. */
    command.position_m = 0.123;
    command.velocity_m_per_s = 0.0;
    for (int i = 0; i < 400; i++) {
        manipulator_step(arm.get(), &command, 0.0);
    }
    CHECK(arm->position_m == doctest::Approx(0.123).epsilon(1e-3));
}
