#include <cmath>
#include <doctest/doctest.h>

#include "hal/rig/cantilever.h"
#include "hal/rig/rig_file.h"

using namespace berth;

namespace
{

double compliance(const cantilever &beam, int count)
{
    double sum = 0.0;
    for (const beam_mode &mode : modes_of(beam, count)) {
        sum += 1.0 / mode.stiffness_N_per_m;
    }
    return sum;
}

} // namespace

TEST_CASE("cantilever: the textbook's wave numbers, clamped and hinged")
{
    const double clamped[] = {1.87510406871196, 4.69409113297417, 7.85475743823761, 10.9955407348755,
                              14.1371683910465, 17.2787595320882, 20.4203522510413, 23.5619449018064};
    const cantilever beam = {2.0, 3.0, 50.0};
    const std::vector<beam_mode> modes = modes_of(beam, 8);
    for (int i = 0; i < 8; i++) {
        const beam_mode &mode = modes[static_cast<std::size_t>(i)];
        CHECK(mode.wave_number == doctest::Approx(clamped[i]).epsilon(1e-13));
        CHECK(mode.mass_kg ==
              doctest::Approx(3.0 * 2.0 / 4.0).epsilon(1e-9)); /* a quarter of the beam, every mode */
        const double w = std::pow(clamped[i] / 2.0, 2.0) * std::sqrt(50.0 / 3.0);
        CHECK(mode.frequency_Hz == doctest::Approx(w / (2.0 * 3.14159265358979324)).epsilon(1e-12));
    }
    /* A soft root: the first mode turns as a rigid body, 3 root / (mu L^3); the others are those of a hinge. */
    const cantilever loose = {2.0, 3.0, 50.0, 1e-4};
    const double hinged[] = {3.92660231204791, 7.06858274562873, 10.2101761228130};
    CHECK(2.0 * 3.14159265358979324 * modes_of(loose, 1)[0].frequency_Hz ==
          doctest::Approx(std::sqrt(3.0 * 1e-4 / (3.0 * 8.0))).epsilon(1e-5));
    CHECK(modes_of(loose, 1)[0].mass_kg == doctest::Approx(3.0 * 2.0 / 3.0).epsilon(1e-5)); /* of a turning rod */
    for (int i = 0; i < 3; i++) {
        CHECK(modes_of(loose, 4)[static_cast<std::size_t>(i) + 1].wave_number ==
              doctest::Approx(hinged[i]).epsilon(1e-5));
    }
}

TEST_CASE("cantilever: modes together give the beam's static compliance, L^3 / (3 E I) + L^2 / root")
{
    for (const double root : {static_cast<double>(INFINITY), 200.0, 25.0}) {
        const cantilever beam = {2.0, 3.0, 50.0, root};
        const double whole = 8.0 / 150.0 + (std::isinf(root) ? 0.0 : 4.0 / root);
        double missing = 1.0;
        for (int count = 1; count <= beam_modes_max; count++) {
            const double still = 1.0 - compliance(beam, count) / whole;
            CHECK(still > 0.0);
            CHECK(still < missing);
            missing = still;
        }
        CHECK(missing < 2e-4);
    }
    CHECK(compliance({2.0, 3.0, 50.0}, 1) * 150.0 / 8.0 ==
          doctest::Approx(0.97068).epsilon(1e-4)); /* 12 / 1.8751^4 */
}

TEST_CASE("cantilever: the object of the reference case is a beam's first mode")
{
    const rig ess = load_rig("ess");
    const double w = std::sqrt(ess.object.stiffness_N_per_m / ess.object.mass_kg);
    const cantilever beam = beam_for(8.0, w / (2.0 * 3.14159265358979324), ess.object.mass_kg, 0.02);
    const beam_mode first = modes_of(beam, 3).front();
    CHECK(first.mass_kg == doctest::Approx(ess.object.mass_kg).epsilon(1e-9));
    CHECK(first.stiffness_N_per_m == doctest::Approx(ess.object.stiffness_N_per_m).epsilon(1e-9));
    CHECK(first.damping_N_s_per_m == doctest::Approx(ess.object.damping_N_s_per_m).epsilon(1e-9));
    CHECK_THROWS_AS(modes_of(beam, 0), input_error);
    CHECK_THROWS_AS(modes_of(beam, 9), input_error);
    CHECK_THROWS_AS(modes_of({0.0, 1.0, 1.0}, 1), input_error);
}
