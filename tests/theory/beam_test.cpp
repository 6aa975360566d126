/* A beam as the gripped object: what stability reckons with is what runs, whatever its modes. */
#include <cmath>
#include <doctest/doctest.h>

#include "../../hal/rig/beam.h"
#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/hil/random.h"
#include "../../sim_hal/solver/solver.h"
#include "../../sim_hal/stability/hardware_chain.h"
#include "../../sim_hal/stability/spectrum.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

/* Of all kinds: eigenvalues in pairs and real ones, next to each other in any order. */
rig drawn_beam(random_stream &random)
{
    const auto log_between = [&](double low, double high) { return low * std::pow(high / low, random.uniform()); };
    rig rig = load_rig("ess-beam");
    rig.object.modes = 2 + static_cast<std::int64_t>(7.0 * random.uniform());
    rig.object.beam.length_m = log_between(1.0, 30.0);
    rig.object.beam.mass_kg_per_m = log_between(5.0, 100.0);
    rig.object.beam.bending_stiffness_N_m2 = log_between(1e4, 1e7);
    rig.object.beam.damping_ratio = random.happens(0.5) ? log_between(0.005, 0.1) : random.uniform();
    if (random.happens(0.5)) {
        rig.object.beam.root_N_m_per_rad =
            rig.object.beam.bending_stiffness_N_m2 / rig.object.beam.length_m * log_between(1e-3, 1e3);
    }
    rig.sensor.stiffness_N_per_m = log_between(1e4, 2e7);
    rig.sensor.damping_ratio = log_between(0.01, 5.0);
    if (random.happens(0.3)) {
        rig.robot.transfer_frequency_Hz = log_between(6.0, 30.0);
    }
    const auto error = complete_and_check(rig);
    CAPTURE(error.value_or(rig_error{}).message);
    REQUIRE(!error);
    return rig;
}

} // namespace

TEST_CASE("beam: the links that eigenvalues are made of move as the exact solver does")
{
    REPRODUCIBLE();
    random_stream random(test_seed(), 41);
    double worst = 0.0;
    for (int i = 0; i < 200; i++) {
        const rig rig = drawn_beam(random);
        CAPTURE(i);
        CAPTURE(rig.object.modes);
        const hardware_chain chain(rig);
        const auto solver = make_fast_solver(rig, plant(rig));
        const beam_state scales = chain.equations().natural_scales<beam_state>();
        beam_state by_solver = beam_state::Zero();
        for (int k = 0; k < chain.state_count(); k++) {
            by_solver(chain.state(k)) = scales(chain.state(k)) * (random.uniform() - 0.5);
        }
        beam_state by_links = by_solver;
        const auto duration_ns = static_cast<std::int64_t>(1e4 * std::pow(1e3, random.uniform()));
        const reference_line line{random.uniform(), 10.0 * random.uniform()};
        hardware_chain::transition change;
        chain.set_transition(change, static_cast<double>(duration_ns) * 1e-9);
        chain.advance(by_links, change, line);
        solver->advance(by_solver, line, duration_ns);
        const double error = (by_links - by_solver).cwiseQuotient(scales).cwiseAbs().maxCoeff();
        worst = std::max(worst, error);
        CHECK(error < 1e-9);
    }
    MESSAGE("worst of 200 beams: " << worst);
}

TEST_CASE("beam: at rest every spring pulls with the same force, and nothing moves")
{
    REPRODUCIBLE();
    random_stream random(test_seed(), 42);
    for (int i = 0; i < 50; i++) {
        const rig rig = drawn_beam(random);
        const plant plant(rig);
        const beam_state rest = plant.at_rest<beam_state>(0.01);
        const double force_N = plant.spring_force_N(rest, {0.01, 0.0});
        double compliance_m_per_N = 0.0;
        for (const beam_mode &mode : object_modes(rig.object)) {
            compliance_m_per_N += 1.0 / mode.stiffness_N_per_m;
        }
        CHECK(rest(object_position) == doctest::Approx(force_N * compliance_m_per_N).epsilon(1e-6));
        const beam_state rate = plant.derivative(rest, {0.01, 0.0});
        const beam_state scales = plant.natural_scales<beam_state>();
        const double w = std::sqrt(plant.sensor_stiffness_N_per_m / plant.mass_kg);
        CHECK(rate.cwiseQuotient(scales).cwiseAbs().maxCoeff() < 1e-12 * w);
    }
}

TEST_CASE("beam: an object that is changed is so in all modes, until it is another beam")
{
    rig rig = load_rig("ess-beam");
    const double first_N_per_m = rig.object.stiffness_N_per_m;
    const double third_N_per_m = object_mode(rig.object, 2).stiffness_N_per_m;
    CHECK(third_N_per_m / first_N_per_m == doctest::Approx(std::pow(7.85475743823761 / 1.87510406871196, 4.0)));
    rig.object.stiffness_N_per_m *= 2.0;
    REQUIRE(!complete_and_check(rig));
    CHECK(object_mode(rig.object, 2).stiffness_N_per_m == doctest::Approx(2.0 * third_N_per_m).epsilon(1e-12));
    CHECK(object_mode(rig.object, 2).damping_N_s_per_m ==
          doctest::Approx(2.0 * 0.02 * std::sqrt(third_N_per_m * 100.0)).epsilon(1e-9));
    rig.object.beam.bending_stiffness_N_m2 *= 3.0;
    REQUIRE(!complete_and_check(rig));
    CHECK(rig.object.stiffness_N_per_m == doctest::Approx(3.0 * first_N_per_m).epsilon(1e-12));
    CHECK(object_mode(rig.object, 2).stiffness_N_per_m == doctest::Approx(3.0 * third_N_per_m).epsilon(1e-12));
}

TEST_CASE("beam: without a loop it swings with the manipulator as its modes say, and refuses no number of them")
{
    for (std::int64_t modes = 1; modes <= beam_modes_max; modes++) {
        const rig rig = load_rig("ess-beam", {"object.modes=" + std::to_string(modes)});
        CHECK(coupled_spectrum(rig).modes.size() == static_cast<std::size_t>(2 * modes));
        CHECK(loop_spectrum(rig).spectral_radius == doctest::Approx(spectral_radius_of(rig)).epsilon(1e-11));
    }
}

} // namespace berth
