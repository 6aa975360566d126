#include <cmath>
#include <doctest/doctest.h>

#include "../../firmware/pi.h"
#include "firmware/arm/attitude_control.h"
#include "firmware/arm/integrators.h"
#include "hal/rig/arm_file.h"
#include "sim_hal/arm/urdf.h"
#include "tests/support/files.h"
#include "tests/support/one_joint_arm.h"

using namespace berth;

namespace
{

/* One link on a held base, its motor as good as fixed: I q'' + d q' + k q = torque of the force. */
arm_config pendulum(double w_rad_per_s, double damping_ratio = 0.0)
{
    arm_config config = one_joint_arm();
    arm_joint &joint = config.joints[0];
    joint.link.mass_kg = 4.0;
    joint.link.centre_m[0] = 0.5;
    joint.link.inertia_kg_m2[5] = 1.0; /* 2 kg m2 about the joint */
    joint.stiffness_N_m_per_rad = 2.0 * w_rad_per_s * w_rad_per_s;
    joint.damping_N_m_s_per_rad = 2.0 * damping_ratio * w_rad_per_s * 2.0;
    joint.rotor_inertia_kg_m2 = 1e12;
    return config;
}

chain_input<plane> no_input()
{
    return {wrench_of<plane>::zero(), plane::angular::Zero(), plane::angular::Zero(), joint_vector::Zero(),
            joint_vector::Zero()};
}

/* Largest deflection over the last tenth of so many steps from 1 mrad: the equations are linear there. */
double swing_after(arm_integrator integrator, double w_rad_per_s, double step_s, int steps)
{
    const chain<plane> chain = make_chain<plane>(pendulum(w_rad_per_s));
    chain_state<plane> state;
    state.link_rad()(0) = 1e-3;
    double largest = 0.0;
    for (int i = 0; i < steps; i++) {
        state = advanced(chain, state, no_input(), integrator, step_s, 0.0);
        const double swing = std::fabs(state.link_rad()(0));
        if (!(swing < 1e6)) {
            return INFINITY;
        }
        largest = i > steps - steps / 10 ? std::max(largest, swing) : largest;
    }
    return largest;
}

/* Largest w h at which the swing does not grow a hundredfold in 4000 steps, by halving. */
double stability_limit(arm_integrator integrator)
{
    double stable = 0.1;
    double unstable = 10.0;
    for (int i = 0; i < 40; i++) {
        const double middle = 0.5 * (stable + unstable);
        (swing_after(integrator, middle, 1.0, 4000) < 0.1 ? stable : unstable) = middle;
    }
    return stable;
}

arm_config ess_arm()
{
    return load_arm("ess").config;
}

/* The whole arm, driven and pushed for a second: its state's difference to steps of a 64th. */
double error_of_second(arm_integrator integrator, double step_s)
{
    arm_config config = ess_arm();
    config.joints[0].torque_limit_N_m = config.joints[1].torque_limit_N_m = INFINITY; /* no kinks */
    const chain<plane> chain = make_chain<plane>(config);
    chain_input<plane> input = no_input();
    input.tool.force = plane::vector(30.0, -20.0);
    input.command_rad << 1.4, -1.65, 0, 0, 0, 0, 0;
    input.command_rad_per_s << 0.05, -0.04, 0, 0, 0, 0, 0;
    const auto run = [&](arm_integrator with, double h) {
        chain_state<plane> state = state_at_start<plane>(config);
        const int steps = static_cast<int>(std::lround(1.0 / h));
        for (int i = 0; i < steps; i++) {
            state = advanced(chain, state, input, with, h, i * h);
        }
        return state;
    };
    return (run(integrator, step_s).values - run(ARM_RK4, 1.0 / 8192).values).norm();
}

/* Of an arm that swings free of dampers and servos while a held force pushes its tool for 10 s: the largest
 * energy that comes of nothing, as a share of the largest work of the force. */
template <class Space>
double energy_of_nothing(arm_config config, arm_integrator integrator, double step_s)
{
    for (int i = 0; i < config.joint_count; i++) {
        config.joints[i].damping_N_m_s_per_rad = 0.0;
        config.joints[i].servo_frequency_Hz = 0.0;
    }
    const chain<Space> chain = make_chain<Space>(config);
    chain_state<Space> state = state_at_start<Space>(config);
    for (int i = 0; i < config.joint_count; i++) {
        state.link_rate()(i) = state.motor_rate()(i) = 0.1 * (i + 1);
    }
    chain_input<Space> input{wrench_of<Space>::zero(), Space::angular::Zero(), Space::angular::Zero(),
                             state.motor_rad(), joint_vector::Zero()};
    input.tool.force.setConstant(20.0);
    const auto mechanical_J = [&] {
        const chain_energy parts = energy(chain, state);
        return parts.kinetic_J + parts.rotors_J + parts.springs_J;
    };
    const auto tool_m = [&] {
        return (state.base() * tool_in_base(chain, pose_of(chain, joint_vector(state.link_rad())))).origin_m;
    };
    const double start_J = mechanical_J();
    const typename Space::vector start_m = tool_m();
    double made_J = 0.0;
    double work_J = 0.0;
    for (int i = 0; i < std::lround(10.0 / step_s); i++) {
        state = advanced(chain, state, input, integrator, step_s, 0.0);
        const double done_J = input.tool.force.dot(tool_m() - start_m);
        made_J = std::max(made_J, std::fabs(mechanical_J() - start_J - done_J));
        work_J = std::max(work_J, std::fabs(done_J));
    }
    CHECK(work_J > 50.0);
    return made_J / work_J;
}

} // namespace

TEST_CASE("arm: sine and cosine are those of the library within an ulp of 1, also far out")
{
    double worst = 0.0;
    const auto look_at = [&](double angle_rad) {
        const sine_cosine turn = sine_and_cosine(angle_rad);
        worst = std::max(
            {worst, std::fabs(turn.sine - std::sin(angle_rad)), std::fabs(turn.cosine - std::cos(angle_rad))});
    };
    for (int i = -80000; i <= 80000; i++) {
        look_at(1e-4 * i);
        look_at(12.3456789 * i);
    }
    CHECK(worst <= 2.3e-16);
    CHECK(std::isnan(sine_and_cosine(NAN).sine));
    CHECK(std::isnan(sine_and_cosine(INFINITY).cosine));
    CHECK(sine_and_cosine(0.0).sine == 0.0);
    CHECK(sine_and_cosine(0.0).cosine == 1.0);
}

TEST_CASE("arm: integrators have the order that they claim")
{
    const struct {
        arm_integrator integrator;
        double order;
    } claims[] = {{ARM_SEMI_IMPLICIT_EULER, 1.0}, {ARM_RK4, 4.0}, {ARM_IMPLICIT_MIDPOINT, 2.0}};
    for (const auto &claim : claims) {
        const double coarse = error_of_second(claim.integrator, 1.0 / 128);
        const double fine = error_of_second(claim.integrator, 1.0 / 256);
        CAPTURE(static_cast<int>(claim.integrator));
        CHECK(std::log2(coarse / fine) == doctest::Approx(claim.order).epsilon(0.06));
    }
}

TEST_CASE("arm: the stiffest joint that a step bears")
{
    CHECK(stability_limit(ARM_SEMI_IMPLICIT_EULER) == doctest::Approx(2.0).epsilon(0.001));
    CHECK(stability_limit(ARM_RK4) == doctest::Approx(std::sqrt(8.0)).epsilon(0.002));
    for (const double stiff : {10.0, 1e3, 1e6}) { /* w h */
        CHECK(swing_after(ARM_IMPLICIT_MIDPOINT, stiff, 1.0, 4000) <= 1.0001e-3);
    }
}

TEST_CASE("arm: energy of a free swing and of a held force")
{
    const double w = 2.0 * pi;
    const chain<plane> chain = make_chain<plane>(pendulum(w));
    chain_input<plane> input = no_input();
    const auto mechanical = [&](const chain_state<plane> &state) {
        const chain_energy parts = energy(chain, state);
        return parts.kinetic_J + parts.springs_J;
    };
    const auto tool_y = [&](const chain_state<plane> &state) {
        return (tool_in_base(chain, pose_of(chain, joint_vector(state.link_rad())))).origin_m(1);
    };
    chain_state<plane> state;
    state.link_rad()(0) = 0.3;
    const double start_J = mechanical(state);
    for (int i = 0; i < 40000; i++) {
        state = advanced(chain, state, input, ARM_IMPLICIT_MIDPOINT, 2.5e-3, 0.0);
    }
    CHECK(mechanical(state) == doctest::Approx(start_J).epsilon(1e-11));

    /* What the arm gains is force times way, for the implicit midpoint: no energy is made. Semi-implicit Euler,
     * whose way is that of the new velocity, loses h^2 F^2 / (2 m) a step beside it (loop.md's closed form). */
    constexpr double force_N = 50.0;
    constexpr double mass_kg = 2.0; /* 2 kg m2 at 1 m */
    constexpr double h = 2.5e-3;
    input.tool.force = plane::vector(0.0, force_N);
    for (const arm_integrator integrator : {ARM_IMPLICIT_MIDPOINT, ARM_SEMI_IMPLICIT_EULER}) {
        const berth::chain<plane> loose = make_chain<plane>(pendulum(1e-9));
        chain_state<plane> from;
        const chain_state<plane> to = advanced(loose, from, input, integrator, h, 0.0);
        const double gained_J = energy(loose, to).kinetic_J - energy(loose, from).kinetic_J;
        const double made_J = gained_J - force_N * (tool_y(to) - tool_y(from));
        const double closed_form_J =
            integrator == ARM_IMPLICIT_MIDPOINT ? 0.0 : -h * h * force_N * force_N / (2.0 * mass_kg);
        CHECK(made_J == doctest::Approx(closed_form_J).epsilon(1e-6).scale(1e-6));
    }
}

TEST_CASE("arm: energy that comes of nothing while a force pushes a whole arm on a free base")
{
    const double midpoint = energy_of_nothing<plane>(ess_arm(), ARM_IMPLICIT_MIDPOINT, 2.5e-3);
    const double rk4 = energy_of_nothing<plane>(ess_arm(), ARM_RK4, 2.5e-3);
    const double euler = energy_of_nothing<plane>(ess_arm(), ARM_SEMI_IMPLICIT_EULER, 2.5e-3);
    MESSAGE("of the work, two joints: implicit midpoint ", midpoint, ", Runge-Kutta ", rk4, ", semi-implicit Euler ",
            euler);
    CHECK(midpoint < 1e-6);
    CHECK(rk4 < 1e-8);
    CHECK(euler > 100.0 * midpoint);
    CHECK(midpoint / energy_of_nothing<plane>(ess_arm(), ARM_IMPLICIT_MIDPOINT, 1.25e-3) ==
          doctest::Approx(4.0).epsilon(0.15));
    CHECK(euler / energy_of_nothing<plane>(ess_arm(), ARM_SEMI_IMPLICIT_EULER, 1.25e-3) ==
          doctest::Approx(2.0).epsilon(0.15));
}

#ifdef BERTH_WITH_URDF
TEST_CASE("arm: the same with seven joints in space")
{
    const std::string urdf = "tests/arms/seven.urdf";
    arm_config seven = arm_from_urdf(read_bytes(urdf), urdf, {"", "gripper", false}).config;
    for (int i = 0; i < seven.joint_count; i++) {
        seven.joints[i].initial_rad = 0.4 + 0.2 * i;
    }
    const double coarse = energy_of_nothing<space>(seven, ARM_IMPLICIT_MIDPOINT, 2.5e-3);
    const double fine = energy_of_nothing<space>(seven, ARM_IMPLICIT_MIDPOINT, 1.25e-3);
    MESSAGE("of the work, seven joints: implicit midpoint ", coarse, ", at half the step ", fine);
    CHECK(coarse < 1e-5);
    CHECK(fine < 0.5 * coarse);
}
#endif

TEST_CASE("arm: a free base moves against the arm, and the wheel takes what turns it")
{
    arm_config config = ess_arm();
    const chain<plane> chain = make_chain<plane>(config);
    chain_state<plane> state = state_at_start<plane>(config);
    attitude_control<plane> control = attitude_control_at(state);
    chain_input<plane> input = no_input();
    for (int i = 0; i < 8000; i++) {
        attitude_control_step(control, config.attitude, 2.5e-3, state);
        input.wheel_torque_N_m = control.wheel_torque_N_m;
        const double share = std::min(1.0, i / 4000.0);
        input.command_rad << 1.35 + 0.2 * share, -1.7 - 0.3 * share, 0, 0, 0, 0, 0;
        state = advanced(chain, state, input, ARM_IMPLICIT_MIDPOINT, 2.5e-3, 0.0);
    }
    const wrench_of<plane> total = momentum(chain, state);
    CHECK(std::fabs(total.torque(0)) < 1e-6);
    CHECK(total.force.norm() < 1e-7);
    CHECK(state.position_m().norm() > 1e-3);
    CHECK(std::fabs(state.wheel()(0)) > 0.1);
    CHECK(std::fabs(state.attitude()(0)) < 0.05);
}

TEST_CASE("arm: thrusters fire pulses of their least length against an error beyond the deadband")
{
    attitude_config config = {};
    config.actuator = ATTITUDE_THRUSTERS;
    config.period_ticks = 4;
    config.torque_limit_N_m = 5.0;
    config.deadband_rad = 0.01;
    config.rate_weight_s = 2.0;
    config.on_time_min_ms = 50.0;
    chain_state<plane> state;
    attitude_control<plane> control = attitude_control_at(state);
    state.attitude()(0) = 0.02;
    int fired = 0;
    for (int tick = 0; tick < 100; tick++) {
        attitude_control_step(control, config, 2.5e-3, state);
        CHECK((control.thruster_torque_N_m(0) == 0.0 || control.thruster_torque_N_m(0) == -5.0));
        fired += control.thruster_torque_N_m(0) != 0.0 ? 1 : 0;
        if (tick == 2) {
            state.attitude()(0) = 0.0; /* the error has gone; the pulse lasts */
        }
    }
    CHECK(fired == 20);           /* 50 ms */
    state.turn_rate()(0) = -0.02; /* weighs as -0.04 rad */
    attitude_control_step(control, config, 2.5e-3, state);
    CHECK(control.thruster_torque_N_m(0) == 5.0);
}

TEST_CASE("arm: a thruster's pulse is over before the law is due again if it is shorter")
{
    attitude_config config = {};
    config.actuator = ATTITUDE_THRUSTERS;
    config.period_ticks = 100;
    config.torque_limit_N_m = 5.0;
    config.deadband_rad = 0.01;
    chain_state<plane> state;
    state.attitude()(0) = -0.02;
    for (const auto &[on_time_min_ms, ticks] :
         {std::pair(50.0, 20), std::pair(51.0, 21), std::pair(1.0, 1), std::pair(0.0, 1), std::pair(375.0, 150)}) {
        config.on_time_min_ms = on_time_min_ms;
        attitude_control<plane> control = attitude_control_at(chain_state<plane>());
        int fired = 0;
        for (int tick = 0; tick < 400; tick++) {
            attitude_control_step(control, config, 2.5e-3, state);
            fired += control.thruster_torque_N_m(0) == 5.0 ? 1 : 0;
        }
        /* Looks at 0, 100, 200, 300; a pulse of 150 ticks lasts over the one at 100 and over that at 300. */
        CHECK(fired == (ticks < 100 ? 4 * ticks : 300));
    }
}

TEST_CASE("arm: a motor at its torque limit gives that torque and no more")
{
    arm_config config = pendulum(20.0, 0.1);
    config.joints[0].rotor_inertia_kg_m2 = 1.0;
    config.joints[0].servo_frequency_Hz = 5.0;
    config.joints[0].servo_damping_ratio = 0.7;
    config.joints[0].torque_limit_N_m = 3.0;
    const chain<plane> chain = make_chain<plane>(config);
    chain_input<plane> input = no_input();
    input.command_rad(0) = 1e3;
    for (const arm_integrator integrator : {ARM_SEMI_IMPLICIT_EULER, ARM_RK4, ARM_IMPLICIT_MIDPOINT}) {
        chain_state<plane> state;
        for (int i = 0; i < 800; i++) {
            state = advanced(chain, state, input, integrator, 2.5e-3, 0.0);
        }
        /* 3 N m on 1 + 2 kg m2 for 2 s. */
        CHECK(state.motor_rate()(0) == doctest::Approx(2.0).epsilon(0.02));
    }
}
