/* What is read from a force sensor at standstill, and up to which feedback a loop may be closed. */
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

#include "hal/rig/rig_file.h"
#include "hal/rig/tool_load.h"
#include "seeded.h"
#include "sim_hal/commission/gain_limit.h"
#include "sim_hal/commission/standstill.h"
#include "sim_hal/stability/spectrum.h"

namespace
{

std::vector<double> samples(double mean, double noise, double drift_per_s, std::size_t count, double step_s)
{
    SEEDED(random, "standstill*");
    std::normal_distribution<double> normal;
    std::vector<double> made;
    for (std::size_t i = 0; i < count; i++) {
        const double time_s = step_s * (static_cast<double>(i) - 0.5 * (static_cast<double>(count) - 1.0));
        made.push_back(mean + drift_per_s * time_s + noise * normal(random));
    }
    return made;
}

berth::pose_reading pose(const berth::tool_rig &tool, const berth::sensor_load &zero, std::array<double, 3> gravity)
{
    berth::tool_rig posed = tool;
    posed.gravity_m_per_s2 = gravity;
    berth::pose_reading reading{gravity, berth::tool_load(posed)};
    for (std::size_t i = 0; i < 6; i++) {
        reading.load[i] += zero[i];
    }
    return reading;
}

} // namespace

TEST_CASE("standstill: mean, noise and drift of white noise about a line")
{
    const berth::standstill found = berth::standstill_of(samples(-12.0, 0.5, 0.2, 4000, 2.5e-3), 2.5e-3);
    CHECK(std::fabs(found.mean + 12.0) < 4.0 * found.mean_error());
    CHECK(found.mean_error() == doctest::Approx(0.5 / std::sqrt(4000.0)).epsilon(0.05));
    CHECK(found.noise == doctest::Approx(0.5).epsilon(0.05));
    CHECK(std::fabs(found.drift_per_s - 0.2) < 4.0 * found.drift_error);
    /* The closed form for n samples every h: s / (h sqrt(n^3 / 12)). */
    CHECK(found.drift_error ==
          doctest::Approx(0.5 / (2.5e-3 * std::sqrt(std::pow(4000.0, 3) / 12.0))).epsilon(0.05));
    CHECK(found.drifts(0.1));
    CHECK(!found.drifts(3.0));
    CHECK(!berth::standstill_of(samples(-12.0, 0.5, 0.0, 4000, 2.5e-3), 2.5e-3).drifts(0.0));
    CHECK(berth::standstill_of({}, 1.0).samples == 0);
    CHECK(berth::standstill_of({3.0}, 1.0).mean == 3.0);
}

TEST_CASE("standstill: poses tell zero, mass and centre of mass of the tool")
{
    const double g = 9.80665;
    berth::tool_rig tool;
    tool.mass_kg = 3.7;
    tool.centre_m = {0.01, -0.02, 0.13};
    const berth::sensor_load zero = {4.0, -5.0, 6.0, 0.7, -0.8, 0.9};
    const std::vector<berth::pose_reading> poses = {pose(tool, zero, {0, 0, -g}), pose(tool, zero, {g, 0, 0}),
                                                    pose(tool, zero, {0, -g, 0})};
    const berth::tool_estimate all = berth::estimate_tool(poses, berth::sensor_axes::all, {});
    CHECK(all.mass_is_measured);
    CHECK(all.centre_is_measured);
    CHECK(all.tool.mass_kg == doctest::Approx(3.7));
    for (std::size_t i = 0; i < 3; i++) {
        CHECK(all.tool.centre_m[i] == doctest::Approx(tool.centre_m[i]));
    }
    for (std::size_t i = 0; i < 6; i++) {
        CHECK(all.zero[i] == doctest::Approx(zero[i]));
    }
    const berth::tool_estimate forces = berth::estimate_tool(poses, berth::sensor_axes::forces, {});
    CHECK(forces.tool.mass_kg == doctest::Approx(3.7));
    CHECK(!forces.centre_is_measured);
    const berth::tool_estimate one = berth::estimate_tool(poses, berth::sensor_axes::one, {});
    CHECK(one.tool.mass_kg == doctest::Approx(3.7));
    CHECK(one.zero[0] == doctest::Approx(4.0));
}

TEST_CASE("standstill: poses with gravity the same way tell the zero alone")
{
    berth::tool_rig tool;
    tool.mass_kg = 3.7;
    const berth::sensor_load zero = {4.0, 0, 0, 0, 0, 0};
    const auto down = pose(tool, zero, {0, 0, -9.8});
    berth::tool_rig assumed;
    assumed.mass_kg = 3.0;
    const auto found = berth::estimate_tool({down, down}, berth::sensor_axes::all, assumed);
    CHECK(!found.mass_is_measured);
    CHECK(!found.centre_is_measured);
    CHECK(found.tool.mass_kg == 3.0);
    CHECK(found.zero[0] == doctest::Approx(4.0));
    CHECK(found.zero[2] == doctest::Approx(0.7 * 9.8)); /* what the assumed tool leaves */
    /* The sensor's one axis is level in both poses. */
    const auto level = pose(tool, zero, {0, -9.8, 0});
    CHECK(!berth::estimate_tool({down, level}, berth::sensor_axes::one, assumed).mass_is_measured);
}

TEST_CASE("standstill: the gain at which damping falls below a margin")
{
    /* 0.05 - 0.08 g is 0.01 at g = 0.5. */
    const auto falling = [](double gain) { return 0.05 - 0.08 * gain; };
    CHECK(*berth::gain_limit(falling, 0.01) == doctest::Approx(0.5).epsilon(1e-3));
    CHECK(*berth::gain_limit(falling, 0.01) <= 0.5);
    CHECK(!berth::gain_limit(falling, -0.04));
    CHECK(*berth::gain_limit(falling, 0.06) == doctest::Approx(0.0).epsilon(1e-3));
    /* Not monotonic: the first time counts. */
    CHECK(*berth::gain_limit([](double gain) { return std::fabs(gain - 0.3) < 0.05 ? -1.0 : 1.0; }, 0.0) ==
          doctest::Approx(0.25).epsilon(1e-3));
}

TEST_CASE("standstill: a loop with a share of its force is that loop with a weaker sensor")
{
    const berth::rig ess = berth::load_rig("ess", {"object.mass_kg=210"});
    CHECK(berth::least_damping_ratio(ess) < 0.0);
    CHECK(berth::least_damping_ratio(berth::with_feedback_gain(ess, 1.0)) == berth::least_damping_ratio(ess));
    const berth::rig half = berth::load_rig("ess", {"object.mass_kg=210", "sensor.gain_error=-0.5"});
    CHECK(berth::least_damping_ratio(berth::with_feedback_gain(ess, 0.5)) ==
          doctest::Approx(berth::least_damping_ratio(half)));
    /* Without feedback nothing is left but the manipulator, of 0.05, and the hardware. */
    double manipulator = 1.0;
    for (const berth::mode &mode : berth::loop_spectrum(berth::with_feedback_gain(ess, 0.0)).modes) {
        if (std::fabs(mode.frequency_Hz - std::sqrt(1.0 - 0.0025)) < 1e-3) {
            manipulator = mode.damping_ratio;
        }
    }
    CHECK(manipulator == doctest::Approx(0.05).epsilon(1e-3));
}
