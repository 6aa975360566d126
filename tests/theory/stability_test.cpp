/* Limits of stability against closed forms. */
#include <cmath>
#include <doctest/doctest.h>

#include "../../firmware/pi.h"
#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/stability/dominant_root.h"
#include "../../sim_hal/stability/first_order_limit.h"
#include "../../sim_hal/stability/limits.h"

namespace berth
{

namespace
{

void check(rig &rig)
{
    const auto error = complete_and_check(rig);
    const std::string message = error ? error->key + ": " + error->message : "";
    CAPTURE(message);
    REQUIRE(!error);
}

/* ess without damping, its manipulator slow (0.25 Hz) so that the delay is short against its period. */
rig slow_rig()
{
    rig rig = load_rig("ess");
    manipulator_config &m = rig.firmware.manipulator;
    m.stiffness_N_per_m = m.mass_kg * std::pow(two_pi * 0.25, 2);
    m.damping_N_s_per_m = 0.0;
    rig.object.damping_N_s_per_m = 0.0;
    return rig;
}

double coupled_rad_per_s(const rig &rig)
{
    const manipulator_config &m = rig.firmware.manipulator;
    return std::sqrt((m.stiffness_N_per_m + rig.object.stiffness_N_per_m) / (m.mass_kg + rig.object.mass_kg));
}

/* Damping ratio of the coupled system at which the loop is just stable, the object's damper being varied. */
double exact_damping_limit(rig rig)
{
    rig.object.damping_N_s_per_m = 20.0;
    const parameter_limits damping = find_limits(rig, "object.damping_N_s_per_m");
    REQUIRE(!damping.limits.empty());
    const stability_limit &limit = damping.limits.front();
    REQUIRE(limit.stable_above);
    REQUIRE(limit.mode_name == "slow mode: manipulator and object together");
    rig.object.damping_N_s_per_m = limit.value;
    return map_point_of(rig).damping_ratio;
}

void check_damping_limit(rig rig, const std::string &variation)
{
    check(rig);
    const double wt = coupled_rad_per_s(rig) * loop_delay_s(rig);
    REQUIRE(wt >= 0.04);
    REQUIRE(wt <= 0.16);
    const double exact = exact_damping_limit(rig);
    const double formula = first_order_damping_limit(rig);
    MESSAGE(variation << ": w tau " << wt << ", damping limit " << exact << ", by the formula " << formula << " ("
                      << 100.0 * (formula / exact - 1.0) << " %)");
    CHECK(std::abs(formula / exact - 1.0) < 0.01);
}

/* tau_c w0 of M s^2 + (B s + K) exp(-s tau) = 0. */
double free_mass_delay_limit(double damping_ratio)
{
    const double b = 2.0 * damping_ratio;
    const double w = std::sqrt(0.5 * (b * b + std::sqrt(std::pow(b, 4) + 4.0)));
    return std::atan(b * w) / w;
}

/* A free mass M that meets a spring and a damper through nothing but a delay: the manipulator has no spring of its
 * own, the object next to no mass, the sensor is rigid and immediate. A robot of 50 Hz rounds the corners of the
 * straight lines, so that velocity can be sampled anywhere; its lag is a part of the delay. */
rig free_mass(double damping_ratio)
{
    constexpr double w0 = two_pi * 0.2;
    rig rig =
        load_rig("ess", {"bus.ideal=true", "loop.rate_Hz=1000", "sensor.low_pass_order=0", "sensor.delay_ms=0",
                         "sensor.damping_ratio=1", "sensor.stiffness_N_per_m=1e10", "robot.transfer_frequency_Hz=50",
                         "robot.transfer_damping_ratio=0.70710678", "manipulator.stiffness_N_per_m=0",
                         "manipulator.damping_N_s_per_m=0", "object.mass_kg=1e-4"});
    const double mass_kg = rig.firmware.manipulator.mass_kg;
    rig.object.stiffness_N_per_m = mass_kg * w0 * w0;
    rig.object.damping_N_s_per_m = 2.0 * damping_ratio * mass_kg * w0;
    rig.robot.dead_time_ms = 0.5e3 * free_mass_delay_limit(damping_ratio) / w0;
    check(rig);
    return rig;
}

/* Largest m/M that is stable. */
double mass_limit(const rig &rig)
{
    const parameter_limits mass = find_limits(rig, "object.mass_kg");
    REQUIRE(!mass.limits.empty());
    REQUIRE(!mass.limits.back().stable_above);
    return mass.limits.back().value / rig.firmware.manipulator.mass_kg;
}

/* Object, robot and a mass that hangs on the object, all slow against 2 kHz. */
rig slow_at_a_high_rate()
{
    return load_rig("ess", {"bus.ideal=true",
                            "loop.rate_Hz=2000",
                            "robot.dead_time_ms=3.225",
                            "sensor.delay_ms=0.9774",
                            "manipulator.mass_kg=253.3",
                            "manipulator.stiffness_N_per_m=665.0",
                            "manipulator.damping_N_s_per_m=9.171",
                            "object.mass_kg=155.2",
                            "object.stiffness_N_per_m=97.91",
                            "object.damping_N_s_per_m=22.47",
                            "sensor.stiffness_N_per_m=101100",
                            "sensor.damping_ratio=0.2783",
                            "sensor.low_pass_order=1",
                            "sensor.low_pass_frequency_Hz=26.33",
                            "robot.transfer_frequency_Hz=9.449",
                            "robot.transfer_damping_ratio=0.3223",
                            "robot.lag_ms=20.03",
                            "object.second_mass_kg=137.5",
                            "object.second_frequency_Hz=6.324",
                            "object.second_damping_ratio=0.1079"});
}

} // namespace

TEST_CASE("damping limit of the slow mode: the closed form is within 1 % of exact where w tau <= 0.16")
{
    for (const double ratio : {1.2, 1.5, 2.0, 2.5, 3.0}) {
        rig rig = slow_rig();
        const manipulator_config &m = rig.firmware.manipulator;
        rig.object.stiffness_N_per_m =
            ratio * ratio * m.stiffness_N_per_m * (1.0 + rig.object.mass_kg / m.mass_kg) - m.stiffness_N_per_m;
        check_damping_limit(rig, "elasticity");
    }
    for (const double mass_kg : {10.0, 30.0, 60.0, 100.0, 150.0}) {
        rig rig = slow_rig();
        rig.object.stiffness_N_per_m = 5.0 * rig.firmware.manipulator.stiffness_N_per_m;
        rig.object.mass_kg = mass_kg;
        check_damping_limit(rig, "mass");
    }
}

TEST_CASE("the slow mode needs no damping where it is slower than the manipulator alone")
{
    for (const double ratio : {0.85, 0.9, 0.95, 0.99}) {
        rig rig = slow_rig();
        const manipulator_config &m = rig.firmware.manipulator;
        rig.object.stiffness_N_per_m =
            ratio * ratio * m.stiffness_N_per_m * (1.0 + rig.object.mass_kg / m.mass_kg) - m.stiffness_N_per_m;
        check(rig);
        const spectrum spectrum = loop_spectrum(rig);
        MESSAGE("w/w_M " << ratio << ": |z| - 1 = " << spectrum.spectral_radius - 1.0);
        CHECK(spectrum.is_stable);
        CHECK(first_order_damping_limit(rig) < 0.0);
    }
}

/* 1000 Hz and a robot of 50 Hz at 0.2 Hz: held forces, sampled velocities and the robot's phase beyond its delay
 * differ from the continuous motion by some 1e-6; the object's mass is 5e-7 of M, dead times have steps of 1 ns. */
TEST_CASE("free mass against spring and damper: the longest dead time, to four digits and more")
{
    const struct {
        double damping_ratio;
        double published;
    } table[] = {{0.05, 0.09967}, {0.1, 0.19734}, {0.2, 0.37903}, {0.5, 0.71112}, {1.0, 0.64741}};
    for (const auto &row : table) {
        rig rig = free_mass(row.damping_ratio);
        const parameter_limits dead_time = find_limits(rig, "robot.dead_time_ms");
        REQUIRE(dead_time.nearest_above() != nullptr);
        const double w0 = std::sqrt(rig.object.stiffness_N_per_m / rig.firmware.manipulator.mass_kg);
        rig.robot.dead_time_ms = dead_time.nearest_above()->value;
        const double limit = w0 * loop_delay_s(rig);
        const double closed_form = free_mass_delay_limit(row.damping_ratio);
        MESSAGE("zeta " << row.damping_ratio << ": tau_c w0 = " << limit << ", closed form " << closed_form);
        CHECK(std::abs(limit - row.published) < 5.5e-6); /* five decimals */
        CHECK(std::abs(limit / closed_form - 1.0) < 1e-5);
    }
}

/* Values by the definitions in 50 digits (mpmath): where |z| of the critical mode is 1. */
TEST_CASE("limits at a high rate with modes that are slow against it: to eight digits")
{
    const rig rig = slow_at_a_high_rate();
    const auto check_limits = [&](const std::string &key, const std::vector<double> &exact) {
        const parameter_limits found = find_limits(rig, key);
        REQUIRE(found.limits.size() == exact.size());
        for (std::size_t i = 0; i < exact.size(); i++) {
            const double error = found.limits[i].value / exact[i] - 1.0;
            MESSAGE(key << " " << found.limits[i].value << ": " << error << " beside 50 digits");
            CHECK(std::abs(error) < 1e-8);
        }
    };
    check_limits("sensor.damping_ratio", {0.3895742761251471, 1.319492906856609});
    check_limits("object.damping_N_s_per_m", {3991.8952112704965, 9167.134513955463});
    check_limits("manipulator.damping_N_s_per_m", {1420.8116204707806});
}

/* Stiffness and damping in the ratio of the masses: the loop's gain is m/M at every frequency, so that the mass
 * limit is M for any dead time. A robot of 40 Hz makes the motion between setpoints smooth, so that its acceleration
 * can be sampled; at a tick the sample is (w T)^2/12 = 0.5 % low, and so far beyond M is the limit where the dead
 * time is long enough for modes that the robot still passes. */
TEST_CASE("neutral mass limit: with a wide-band robot and sensor the object must be lighter than the manipulator")
{
    rig rig = load_rig("ess", {"bus.ideal=true", "loop.rate_Hz=1000", "sensor.low_pass_order=0", "sensor.delay_ms=0",
                               "sensor.damping_ratio=0.5", "sensor.stiffness_N_per_m=1e10",
                               "robot.transfer_frequency_Hz=40", "robot.transfer_damping_ratio=0.70710678"});
    const manipulator_config &m = rig.firmware.manipulator;
    rig.object.stiffness_N_per_m = m.stiffness_N_per_m;
    rig.object.damping_N_s_per_m = m.damping_N_s_per_m;
    for (const double dead_time_ms : {10.0, 20.0, 50.0, 100.0, 200.0, 400.0}) {
        rig.object.mass_kg = 0.98 * m.mass_kg;
        rig.robot.dead_time_ms = dead_time_ms;
        check(rig);
        CHECK(loop_spectrum(rig).is_stable);
        const double limit = mass_limit(rig);
        struct rig filtered = rig;
        filtered.sensor.low_pass_order = 2;
        MESSAGE("dead time " << dead_time_ms << " ms: m/M < " << limit << "; with a force low-pass of 20 Hz m/M < "
                             << mass_limit(filtered));
        CHECK(limit > 0.999);
        if (dead_time_ms >= 100.0) {
            CHECK(limit < 1.01);
        }
    }
}

} // namespace berth
