#include <cmath>
#include <doctest/doctest.h>
#include <Eigen/Core>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/solver/decompositions.h"
#include "../../sim_hal/solver/power_iteration.h"
#include "../../sim_hal/stability/spectrum.h"

namespace berth
{

namespace
{

/* A delay of so many places with two modes around it, as the map of a period has. */
Eigen::MatrixXd delayed_oscillator(Eigen::Index places, double modulus)
{
    constexpr double turn_rad = 0.02;
    Eigen::MatrixXd map = Eigen::MatrixXd::Zero(places + 2, places + 2);
    map.topLeftCorner(2, 2) << std::cos(turn_rad), -std::sin(turn_rad), std::sin(turn_rad), std::cos(turn_rad);
    map.topLeftCorner(2, 2) *= modulus;
    map(2, 0) = 1.0;
    map.diagonal(-1).tail(places - 1).setOnes();
    return map;
}

} // namespace

TEST_CASE("power iteration: the largest eigenvalue is that of all eigenvalues")
{
    for (const double modulus : {0.97, 0.999, 1.0005, 1.03}) {
        const Eigen::MatrixXd map = delayed_oscillator(200, modulus);
        CHECK(power_radius(map) == doctest::Approx(modulus).epsilon(1e-5));
    }
}

TEST_CASE("power iteration: of a map that forgets everything the radius is 0")
{
    const Eigen::MatrixXd shift = delayed_oscillator(50, 0.0).bottomRightCorner(50, 50);
    CHECK(power_radius(shift) == 0.0);
}

TEST_CASE("power iteration: the guess for a compensated loop is on the same side of 1 as its eigenvalues")
{
    for (const char *method : {"prediction.enabled=true", "extrapolation.order=2", "force_lead.enabled=true"}) {
        for (const char *mass : {"20", "100", "190", "400"}) {
            for (const char *dead_time : {"30", "80", "200"}) {
                const rig loop = load_rig("ess", {method, std::string("object.mass_kg=") + mass,
                                                  std::string("robot.dead_time_ms=") + dead_time});
                CAPTURE(std::string(method));
                CAPTURE(std::string(mass));
                CAPTURE(std::string(dead_time));
                const double radius = spectral_radius_of(loop);
                CHECK((guessed_spectral_radius(loop) < 1.0) == (radius < 1.0));
                CHECK(guessed_spectral_radius(loop) == doctest::Approx(radius).epsilon(1e-5));
            }
        }
    }
}

} // namespace berth
