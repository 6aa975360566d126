/* The object between the robot and the wall, in few steps, against many. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

#include "../../sim_hal/solver/object_steps.h"
#include "hal/rig/rig_file.h"

using namespace berth;

namespace
{

constexpr double step_s = 0.000625;
constexpr int steps = 64;

/* Force after each step while the robot goes through `from_m` + v t; each step in `parts`. */
std::vector<double> forces(const rig &rig, double from_m, double velocity_m_per_s, int parts, bool watches)
{
    object_steps object(rig);
    const double part_s = step_s / parts;
    const auto maps = object.make_maps(part_s);
    const auto fine = object.make_maps(part_s / object_steps::fine_parts);
    object.start(rig, from_m, 0.0);
    double at_m = from_m;
    std::vector<double> made;
    made.reserve(steps);
    for (int step = 0; step < steps; step++) {
        for (int part = 0; part < parts; part++) {
            const robot_way way{at_m, at_m + velocity_m_per_s * part_s};
            if (watches) {
                object.advance_watching(maps, fine, part_s, way, 0.0);
            } else {
                object.advance(maps, part_s, way, 0.0);
            }
            at_m = way.to_m;
        }
        made.push_back(object.measured_N());
    }
    return made;
}

/* Largest difference between few watched steps and many plain ones, in units of the largest force. */
double largest_difference(const rig &rig, double from_m, double velocity_m_per_s)
{
    const auto few = forces(rig, from_m, velocity_m_per_s, 1, true);
    const auto many = forces(rig, from_m, velocity_m_per_s, 2048, false);
    double difference = 0.0;
    double largest = 0.0;
    for (std::size_t i = 0; i < few.size(); i++) {
        difference = std::max(difference, std::abs(few[i] - many[i]));
        largest = std::max(largest, std::abs(many[i]));
    }
    return difference / largest;
}

rig stiff(std::vector<std::string> overrides)
{
    overrides.insert(overrides.end(), {"object.mass_kg=3.5", "object.stiffness_N_per_m=4500",
                                       "object.damping_N_s_per_m=150", "sensor.stiffness_N_per_m=2e6"});
    return load_rig("ess", overrides);
}

} // namespace

TEST_CASE("object: a contact begins within a step as it does in steps two thousand times as short")
{
    const rig rig =
        stiff({"object.kind=contact", "object.surface_position_m=0.0002", "manipulator.initial_position_m=-0.01"});
    for (int phase = 0; phase < 10; phase++) {
        CAPTURE(phase);
        CHECK(largest_difference(rig, -1.25e-6 * phase, 0.02) < 3e-4);
    }
}

TEST_CASE("object: a grip gives way within a step as it does in steps two thousand times as short")
{
    const double velocity_m_per_s = -0.005;
    const rig rig = stiff({"object.grip_force_N=8"});
    for (int phase = 0; phase < 10; phase++) {
        CAPTURE(phase);
        CHECK(largest_difference(rig, -3e-7 * phase, velocity_m_per_s) < 8e-4);
    }
    const auto held = forces(stiff({}), 0.0, velocity_m_per_s, 1, true);
    const auto lost = forces(rig, 0.0, velocity_m_per_s, 1, true);
    CHECK(held != lost);
}

TEST_CASE("object: so it does beside a force that bends the spring, or rubs")
{
    for (const char *const further : {"object.cubic_stiffness_N_per_m3=2e10", "object.coulomb_friction_N=1"}) {
        const rig rig = stiff({"object.grip_force_N=8", further});
        for (int phase = 0; phase < 10; phase++) {
            CAPTURE(further);
            CAPTURE(phase);
            CHECK(largest_difference(rig, -3e-7 * phase, -0.005) < 8e-4);
        }
    }
}

TEST_CASE("object: a corner of the robot's way within a step, told as a bulge, acts as in two steps")
{
    const rig rig = stiff({});
    for (const double share : {0.1, 0.35, 0.5, 0.8}) {
        CAPTURE(share);
        object_steps once(rig);
        object_steps twice(rig);
        once.start(rig, 0.0, 0.0);
        twice.start(rig, 0.0, 0.0);
        const double corner_m = 2e-5 * share;
        const double end_m = corner_m - 1e-5 * (1.0 - share);
        const double mean_m = 0.5 * corner_m * share + 0.5 * (corner_m + end_m) * (1.0 - share);
        once.advance(once.make_maps(step_s), step_s, {0.0, end_m, mean_m - 0.5 * end_m}, 0.0);
        twice.advance(twice.make_maps(share * step_s), share * step_s, {0.0, corner_m}, 0.0);
        twice.advance(twice.make_maps((1.0 - share) * step_s), (1.0 - share) * step_s, {corner_m, end_m}, 0.0);
        object_steps straight(rig);
        straight.start(rig, 0.0, 0.0);
        straight.advance(straight.make_maps(step_s), step_s, {0.0, end_m}, 0.0);
        const double plain = std::abs(straight.state()[object_velocity] - twice.state()[object_velocity]);
        const double told = std::abs(once.state()[object_velocity] - twice.state()[object_velocity]);
        CHECK(told < 0.1 * plain);
    }
}
