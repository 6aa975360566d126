#include <cmath>
#include <complex>
#include <doctest/doctest.h>

#include "firmware/arm/integrators.h"
#include "hal/rig/arm_file.h"
#include "hal/rig/rig_file.h"
#include "sim_hal/stability/reduction.h"
#include "sim_hal/stability/spectrum.h"
#include "tests/support/one_joint_arm.h"
#include "tests/support/seed.h"

using namespace berth;

namespace
{

const Eigen::VectorXd along_x = Eigen::Vector2d::UnitX();

Eigen::VectorXd start_of(const arm_config &config)
{
    Eigen::VectorXd pose(config.joint_count);
    for (Eigen::Index i = 0; i < pose.size(); i++) {
        pose(i) = config.joints[i].initial_rad;
    }
    return pose;
}

arm_config held(arm_config config)
{
    config.base_is_free = 0;
    config.attitude.actuator = ATTITUDE_NONE;
    return config;
}

/* One massless metre with the mass at its end, its motor as good as fixed: across it, it is a mass on spring and
 * damper. */
arm_config one_degree_of_freedom(const manipulator_config &manipulator)
{
    arm_config config = one_joint_arm();
    arm_joint &joint = config.joints[0];
    joint.link.mass_kg = manipulator.mass_kg;
    joint.link.centre_m[0] = 1.0;
    joint.stiffness_N_m_per_rad = manipulator.stiffness_N_per_m;
    joint.damping_N_m_s_per_rad = manipulator.damping_N_s_per_m;
    joint.rotor_inertia_kg_m2 = 1e15;
    config.integrator = ARM_RK4;
    config.substeps = 32;          /* as good as exact, which the manipulator of one degree of freedom is, ... */
    config.force = ARM_FORCE_HELD; /* ... for a force that is held */
    return config;
}

} // namespace

TEST_CASE(
    "reduction: an arm that is a mass on a spring is the manipulator of one degree of freedom, in the loop too")
{
    for (const char *const name : {"ess", "ess-50hz", "ess-half-dead-time"}) {
        for (const char *const more : {"robot.dead_time_ms=41", "robot.interpolation=\"hold\"",
                                       "sensor.low_pass_order=1", "inverse_filter.enabled=false"}) {
            const rig rig = load_rig(name, {more});
            const arm_config config = one_degree_of_freedom(rig.firmware.manipulator);
            const Eigen::VectorXd across = Eigen::Vector2d::UnitY();
            const linear_arm arm = linearise(config, Eigen::VectorXd::Zero(1));
            const arm_mode mode = dominant_mode(modes_along(arm, across));
            CHECK(mode.mass_kg == doctest::Approx(rig.firmware.manipulator.mass_kg).epsilon(1e-9));
            CHECK(mode.stiffness_N_per_m ==
                  doctest::Approx(rig.firmware.manipulator.stiffness_N_per_m).epsilon(1e-9));
            CHECK(mode.damping_N_s_per_m ==
                  doctest::Approx(rig.firmware.manipulator.damping_N_s_per_m).epsilon(1e-9));
            const arm_loop_growth whole =
                growth_of(arm_loop_matrix(rig, config, arm, across), config_period_s(&rig.firmware));
            const spectrum known = loop_spectrum(rig);
            CAPTURE(std::string(name));
            CAPTURE(std::string(more));
            CHECK(whole.spectral_radius == doctest::Approx(known.spectral_radius).epsilon(1e-9));
            CHECK(whole.growth_per_s == doctest::Approx(known.growth_per_s).epsilon(1e-6));
        }
    }
}

TEST_CASE("reduction: the ess arm with its satellite held is the manipulator of the rig ess")
{
    const rig rig = load_rig("ess");
    const arm_config config = held(load_arm("ess").config);
    const reduction found = reduce(rig, config, {start_of(config), along_x, true});
    const manipulator_config &manipulator = rig.firmware.manipulator;
    CHECK(found.reduced.mass_kg == doctest::Approx(manipulator.mass_kg).epsilon(1e-5));
    CHECK(found.reduced.stiffness_N_per_m == doctest::Approx(manipulator.stiffness_N_per_m).epsilon(1e-5));
    CHECK(found.reduced.damping_N_s_per_m == doctest::Approx(manipulator.damping_N_s_per_m).epsilon(1e-5));
    CHECK(found.reduced.share > 0.999);
    /* Full and reduced within 1 % for small motions. */
    REQUIRE(found.coupled_full);
    CHECK(found.coupled_full->frequency_Hz == doctest::Approx(found.coupled_reduced.frequency_Hz).epsilon(0.01));
    CHECK(found.coupled_full->damping_ratio == doctest::Approx(found.coupled_reduced.damping_ratio).epsilon(0.01));
    CHECK(found.loop_full.growth_per_s == doctest::Approx(found.loop_reduced.growth_per_s).epsilon(0.01));
}

TEST_CASE("reduction: of a free satellite one degree of freedom is not enough")
{
    const rig rig = load_rig("ess");
    const arm_config config = load_arm("ess").config;
    const reduction found = reduce(rig, config, {start_of(config), along_x, true});
    double shares = 0.0;
    int springy = 0;
    for (const arm_mode &mode : found.modes) {
        shares += mode.share;
        springy += mode.frequency_Hz > 0.1 && mode.share > 0.1 ? 1 : 0;
    }
    CHECK(shares == doctest::Approx(1.0).epsilon(1e-9));
    CHECK(springy == 2); /* the satellite turns against the arm in the second one */
    CHECK(found.reduced.share < 0.7);
    CHECK(std::fabs(found.coupled_full->damping_ratio / found.coupled_reduced.damping_ratio - 1.0) > 0.03);
    /* In the loop, arm and satellite swing together on the object's spring: the reduced model cannot know of it. */
    CHECK(found.loop_reduced.growth_per_s < -0.5);
    CHECK(found.loop_full.growth_per_s > 0.0);
    CHECK(found.loop_full.frequency_Hz < 0.2);
    /* Unless the satellite is so heavy that it is as good as held. */
    arm_config heavy = config;
    heavy.base.mass_kg = 1e12; /* on the object's spring slower than what counts as free */
    heavy.base.inertia_kg_m2[5] = 1e13;
    const reduction steady = reduce(rig, heavy, {start_of(heavy), along_x, true});
    CHECK(steady.reduced.mass_kg == doctest::Approx(200.0).epsilon(1e-4));
    CHECK(steady.loop_full.growth_per_s == doctest::Approx(steady.loop_reduced.growth_per_s).epsilon(0.01));
}

TEST_CASE("reduction: what the attitude control alone holds is not the arm, whatever the tool has of it")
{
    const rig rig = load_rig("ess");
    const arm_config wheel = load_arm("ess").config;
    arm_config none = wheel;
    none.attitude.actuator = ATTITUDE_NONE;
    int passed_over = 0;
    constexpr int poses = 24;
    const int step = poses > cases_to_draw(poses) ? 5 : 1; /* some are passed over at every fifth, too */
    for (int i = 0; i < poses; i += step) {
        Eigen::VectorXd pose = start_of(wheel);
        pose(1) = -2.7 + 0.11 * i;
        const reduction held_by_wheel = reduce(rig, wheel, {pose, along_x, false});
        const reduction free = reduce(rig, none, {pose, along_x, false});
        CAPTURE(pose(1));
        CHECK(held_by_wheel.reduced.frequency_Hz == doctest::Approx(free.reduced.frequency_Hz).epsilon(1e-3));
        CHECK(held_by_wheel.reduced.mass_kg == doctest::Approx(free.reduced.mass_kg).epsilon(1e-2));
        CHECK(held_by_wheel.reduced.attitude_share < 0.01);
        CHECK(free.reduced.attitude_share == 0.0);
        for (const arm_mode &mode : held_by_wheel.modes) {
            const bool is_slow = mode.frequency_Hz > 0.0 && mode.frequency_Hz < 0.05;
            CHECK((mode.attitude_share > 0.99) == is_slow);
            passed_over += is_slow && mode.share > held_by_wheel.reduced.share ? 1 : 0;
        }
    }
    CHECK(passed_over > 0);
}

TEST_CASE("reduction: small free swings of the whole arm have the eigenvalues of its linear terms")
{
    const arm_config config = held(load_arm("ess").config);
    const chain<plane> chain = make_chain<plane>(config);
    const auto values = eigenvalues_of(linearise(config, start_of(config)));
    const std::complex<double> slow = values.front();
    /* The tool is let go of from a small force; its swing dies with the slow mode. */
    chain_state<plane> state = state_at_start<plane>(config);
    chain_input<plane> input = {wrench_of<plane>::zero(), plane::angular::Zero(), plane::angular::Zero(),
                                joint_vector(state.motor_rad()), joint_vector::Zero()};
    state.link_rad()(0) += 1e-6;
    state.link_rad()(1) += 1e-6;
    const double step_s = 1e-3;
    std::vector<double> crossings_s;
    std::vector<double> peaks;
    double before = state.link_rad()(0) - config.joints[0].initial_rad;
    double peak = 0.0;
    for (int i = 1; i < 60000; i++) {
        state = advanced(chain, state, input, ARM_RK4, step_s, 0.0);
        const double now = state.link_rad()(0) - config.joints[0].initial_rad;
        peak = std::max(peak, std::fabs(now));
        if (i > 20000 && before < 0.0 && now >= 0.0) {
            crossings_s.push_back(step_s * (i - now / (now - before)));
            peaks.push_back(peak);
            peak = 0.0;
        }
        before = now;
    }
    REQUIRE(crossings_s.size() > 10);
    const std::size_t last = crossings_s.size() - 1;
    const double period_s = (crossings_s[last] - crossings_s[1]) / static_cast<double>(last - 1);
    CHECK(2.0 * 3.14159265358979324 / period_s == doctest::Approx(slow.imag()).epsilon(1e-3));
    CHECK(std::log(peaks[last] / peaks[1]) / (crossings_s[last] - crossings_s[1]) ==
          doctest::Approx(slow.real()).epsilon(5e-3));
}
