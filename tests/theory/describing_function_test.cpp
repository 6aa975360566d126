/* Describing functions: what the stages of the simulated rig do to a sine against closed forms from the literature,
 * and limit cycles that harmonic balance predicts against runs that settle. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

#include "../../firmware/pi.h"
#include "../../sim_hal/effects/active.h"
#include "../../sim_hal/effects/velocity_follower.h"
#include "../../sim_hal/hil/manipulator_stand_in.h"
#include "../../sim_hal/stability/equivalent_loop.h"
#include "../../sim_hal/stability/spectrum.h"
#include "../support/closed_loop.h"
#include "../support/key_value.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

using complex = std::complex<double>;

constexpr double w = 2.0 * pi * 0.9;
constexpr double mass_kg = 100.0;

rig ess(const std::vector<std::string> &overrides)
{
    return load_rig("ess", overrides);
}

/* Gain of a signal through the only such stage of the rig. */
complex motion_gain(const rig &rig, double amplitude_m)
{
    return gain_of(*active_stages(rig, &effect::on_motion).at(0), {amplitude_m, 0.0, w});
}

/* The only further force on the object, as F/x. */
complex object_force(const rig &rig, double amplitude_m, double mean_m = 0.0)
{
    const spring_and_damper f =
        force_of(*active_stages(rig, &effect::on_body, "object").at(0), {amplitude_m, mean_m, w}, 0.0, mass_kg);
    return {f.stiffness_N_per_m, f.damping_N_s_per_m * w};
}

double error(complex found, complex expected)
{
    return std::abs(found - expected) / std::abs(expected);
}

} // namespace

/* Gelb and Vander Velde 1968, appendix B; Slotine and Li 1991, 5.2.2. */
TEST_CASE("describing functions: play, for r = half the gap over the amplitude")
{
    for (const double r : {0.05, 0.3, 0.6, 0.9}) {
        const double amplitude_m = 0.01;
        const double u = 1.0 - 2.0 * r;
        const double in_phase = 0.5 + (std::asin(u) + u * std::sqrt(1.0 - u * u)) / pi;
        const complex expected(in_phase, -4.0 * r * (1.0 - r) / pi);
        const complex found = motion_gain(ess({set("robot.backlash_m", 2.0 * r * amplitude_m)}), amplitude_m);
        CHECK(error(found, expected) < 1e-2);
    }
    CHECK(std::abs(motion_gain(ess({"robot.backlash_m=0.03"}), 0.01)) < 1e-12);
}

TEST_CASE("describing functions: gap in a spring, springs of higher order, friction")
{
    const double a = 0.01;
    const double k = ess({}).object.stiffness_N_per_m;
    for (const double d : {0.1, 0.5, 0.9}) { /* half gap over amplitude: what a dead zone lacks */
        const double lacks = -k * 2.0 / pi * (std::asin(d) + d * std::sqrt(1.0 - d * d));
        CHECK(error(object_force(ess({set("object.backlash_m", 2.0 * d * a)}), a), lacks) < 1e-2);
    }
    CHECK(error(object_force(ess({"object.cubic_stiffness_N_per_m3=2e7"}), a), 0.75 * 2e7 * a * a) < 1e-6);
    /* k2 x^2 about a mean: 2 k2 mean, and a mean force k2 (mean^2 + A^2/2). */
    CHECK(error(object_force(ess({"object.quadratic_stiffness_N_per_m2=1e5"}), a, 0.004), 2e5 * 0.004) < 1e-6);
    CHECK(error(object_force(ess({"object.coulomb_friction_N=3"}), a), complex(0.0, 4.0 * 3.0 / (pi * a))) < 1e-2);
}

/* Dahl's force for ways long against its length is dry friction; for short ones a spring Fh/xh. */
TEST_CASE("describing functions: hysteresis between its two ends")
{
    const rig friction_like = ess({"object.hysteresis_force_N=5", "object.hysteresis_length_m=1e-8"});
    CHECK(error(object_force(friction_like, 0.01), complex(0.0, 4.0 * 5.0 / (pi * 0.01))) < 1e-2);
    const rig spring_like = ess({"object.hysteresis_force_N=5", "object.hysteresis_length_m=0.5"});
    CHECK(error(object_force(spring_like, 1e-4), 5.0 / 0.5) < 1e-2);
}

TEST_CASE("describing functions: periodic error by Bessel's function, saturation and steps of the sensor")
{
    const double a = 0.01;
    const double x = 2.0 * pi * a / 4e-3;
    const rig wavy = ess({"robot.periodic_error_m=1e-4", "robot.periodic_error_pitch_m=4e-3"});
    CHECK(std::abs(motion_gain(wavy, a) - (1.0 + 2.0 * 1e-4 * std::cyl_bessel_j(1.0, x) / a)) < 1e-6);

    for (const double s : {0.2, 0.7}) { /* level over amplitude */
        const double expected = 2.0 / pi * (std::asin(s) + s * std::sqrt(1.0 - s * s));
        CHECK(error(sample_gain(ess({set("sensor.saturation_N", 30.0 * s)}), 30.0), expected) < 1e-2);
    }
    /* q (i - 1/2) is passed for the steps i: N = 4 q/(pi A) sum sqrt(1 - ((2 i - 1) q/(2 A))^2) */
    double sum = 0.0;
    for (int i = 1; i <= 5; i++) {
        sum += std::sqrt(std::max(0.0, 1.0 - std::pow((2.0 * i - 1.0) * 1.0 / (2.0 * 5.2), 2.0)));
    }
    CHECK(error(sample_gain(ess({"sensor.resolution_N=1"}), 5.2), 4.0 / (pi * 5.2) * sum) < 1e-2);
    CHECK(sample_gain(ess({"sensor.resolution_N=1"}), 0.4) == 0.0);
}

/* A rate limit deep in saturation makes a triangle of slope V that lags by acos(V pi / (2 A w)): first harmonic
 * 8/pi^2 times its height V pi/(2 w). */
TEST_CASE("describing functions: velocity limit, dead band of setpoints")
{
    const double a = 0.01;
    const double limit_m_per_s = 0.3 * a * w;
    const auto gain = [&](double velocity_max_m_per_s) {
        limited_velocity limiter(velocity_max_m_per_s);
        return gain_of(limiter, {a, 0.0, w});
    };
    const complex found = gain(limit_m_per_s);
    const double height_m = limit_m_per_s * pi / (2.0 * w);
    CHECK(std::abs(std::abs(found) / (8.0 / (pi * pi) * height_m / a) - 1.0) < 1e-2);
    CHECK(std::abs(-std::arg(found) / std::acos(height_m / a) - 1.0) < 2e-2);
    CHECK(error(gain(1.1 * a * w), 1.0) < 1e-9);
    const rig limited = ess({set("robot.velocity_limit_m_per_s", limit_m_per_s)});
    CHECK(error(setpoint_gain(limited, {a, 0.0, w}), 1.0) < 1e-9); /* it is not on the setpoints */
    CHECK(error(setpoint_gain(ess({"robot.gain_error=0.1"}), {a, 0.0, w}), 1.1) < 1e-12);
    /* Steps of delta that come after the sine has passed them: half a step late. */
    const complex stepped = setpoint_gain(ess({"robot.deadband_m=2e-4"}), {a, 0.0, w});
    CHECK(std::abs(std::abs(stepped) - 1.0) < 2e-2);
    CHECK(std::arg(stepped) < -1e-3);
}

/* Within a lag: deep in saturation the same triangle; never saturated the lag itself. */
TEST_CASE("describing functions: velocity limit within a lag")
{
    const double a = 0.01;
    const auto gain = [&](double limit_m_per_s) {
        const rig limited = ess({"robot.lag_ms=5", set("robot.velocity_limit_m_per_s", limit_m_per_s)});
        return gain_of(*find_effect("robot.lag")->on_motion(limited), {a, 0.0, w});
    };
    const double limit_m_per_s = 0.1 * a * w;
    const double height_m = limit_m_per_s * pi / (2.0 * w);
    CHECK(std::abs(std::abs(gain(limit_m_per_s)) / (8.0 / (pi * pi) * height_m / a) - 1.0) < 2e-2);
    CHECK(error(gain(10.0), 1.0 / complex(1.0, 0.005 * w)) < 1e-3);
    CHECK(error(setpoint_gain(ess({"robot.lag_ms=5", "robot.velocity_limit_m_per_s=1e-4"}), {a, 0.0, w}), 1.0) <
          1e-9);
}

TEST_CASE("describing functions: an object that never lets go has the stiffness of its equations")
{
    const rig held = ess({"object.grip_force_N=1e6"});
    const complex s(0.0, w);
    const double damping = held.sensor_damping_N_s_per_m();
    const complex sensor = held.sensor.stiffness_N_per_m + s * damping;
    const complex own =
        held.object.stiffness_N_per_m + s * held.object.damping_N_s_per_m + held.object.mass_kg * s * s;
    CHECK(error(load_of(held, {0.01, 0.0, w}).stiffness_N_per_m, sensor * own / (sensor + own)) < 1e-2);
}

TEST_CASE("equivalent loop: an effect far too small or too large to act leaves the eigenvalues alone")
{
    const double plain_per_s = loop_spectrum(ess({})).growth_per_s;
    for (const char *const idle :
         {"robot.backlash_m=1e-12", "robot.velocity_limit_m_per_s=10", "object.cubic_stiffness_N_per_m3=1e-3",
          "sensor.saturation_N=5000", "object.grip_force_N=1e6"}) {
        CAPTURE(idle);
        const equivalent_loop found = equivalent_finder(0.01).find(ess({idle}));
        CHECK(found.has_settled);
        CHECK(std::abs(found.growth_per_s / plain_per_s - 1.0) < 5e-3);
    }
}

namespace
{

std::vector<double> motion_m(const rig &rig)
{
    closed_loop loop(rig);
    manipulator_stand_in stand_in(rig);
    std::vector<double> position_m;
    while (loop.tick()) {
        stand_in.replace(loop.app());
        position_m.push_back(loop.app().recorder.tick.manipulator_position_m);
    }
    return position_m;
}

/* Nothing of the firmware in the way. */
rig unlimited_ess(std::vector<std::string> overrides)
{
    overrides.insert(overrides.end(),
                     {"limits.velocity_m_per_s=1e3", "limits.acceleration_m_per_s2=1e6", "limits.position_min_m=-5",
                      "limits.position_max_m=5", "sensor_channel.force_limit_N=50000"});
    return ess(overrides);
}

std::vector<double> motion_from(rig rig, double start_m, double duration_s)
{
    rig.firmware.manipulator.initial_position_m = start_m;
    rig.run.duration_s = duration_s;
    return motion_m(rig);
}

/* Half the swing over the last seconds. */
double swing_at_end_m(const std::vector<double> &position_m, double rate_Hz)
{
    const auto last = position_m.end() - static_cast<std::ptrdiff_t>(5.0 * rate_Hz);
    const auto [low, high] = std::minmax_element(last, position_m.end());
    return 0.5 * (*high - *low);
}

double largest_m(const std::vector<double> &position_m)
{
    const auto [low, high] = std::minmax_element(position_m.begin(), position_m.end());
    return std::max(std::abs(*low), std::abs(*high));
}

} // namespace

TEST_CASE("limit cycles: a run settles at the predicted amplitude, from below and above, within 10 %")
{
    const std::vector<std::string> cases[] = {
        {"object.stiffness_N_per_m=12000", "object.cubic_stiffness_N_per_m3=-2e7"},
        {"object.stiffness_N_per_m=40000", "manipulator.cubic_stiffness_N_per_m3=2e7"},
        {"object.stiffness_N_per_m=9000", "robot.backlash_m=1e-3"},
    };
    for (const std::vector<std::string> &overrides : cases) {
        CAPTURE(overrides[1]);
        const rig rig = unlimited_ess(overrides);
        const std::vector<limit_cycle> cycles = limit_cycles(rig, 0.01);
        const auto found =
            std::find_if(cycles.begin(), cycles.end(), [](const limit_cycle &cycle) { return cycle.attracts; });
        REQUIRE(found != cycles.end());
        for (const double share : {0.6, 1.2}) {
            const double swing_there_m =
                swing_at_end_m(motion_from(rig, share * found->amplitude_m, 300.0), rig.firmware.loop.rate_Hz);
            MESSAGE(overrides[1] << ": predicted " << found->amplitude_m << " m at " << found->frequency_Hz
                                 << " Hz, a run from " << share << " of it ends at " << swing_there_m << " m");
            CHECK(std::abs(swing_there_m / found->amplitude_m - 1.0) < 0.1);
        }
    }
}

TEST_CASE("limit cycles: smaller motion decays and larger one grows where harmonic balance says so, within 10 %")
{
    const std::vector<std::string> cases[] = {
        {"object.cubic_stiffness_N_per_m3=2e7"},
        {"object.backlash_m=2e-3", "object.stiffness_N_per_m=40000"},
    };
    for (const std::vector<std::string> &overrides : cases) {
        CAPTURE(overrides[0]);
        const rig rig = unlimited_ess(overrides);
        const std::vector<limit_cycle> cycles = limit_cycles(rig, 0.01);
        REQUIRE(!cycles.empty());
        const limit_cycle cycle = cycles.front();
        REQUIRE(!cycle.attracts);
        const double below_m = 0.9 * cycle.amplitude_m;
        const double above_m = 1.1 * cycle.amplitude_m;
        CHECK(largest_m(motion_from(rig, below_m, 60.0)) < 1.02 * below_m);
        CHECK(largest_m(motion_from(rig, above_m, 60.0)) > 1.3 * above_m);
    }
}

} // namespace berth
