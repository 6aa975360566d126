/* Stability maps: the characteristic equation against dense eigenvalues of the one-period map, the proof that no
 * zero is overlooked, and maps that do not depend on how they are computed. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <random>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/stability/dominant_root.h"
#include "../../sim_hal/stability/loop_equation.h"
#include "../../sim_hal/stability/spectrum.h"
#include "../../sim_hal/stability/stability_map.h"
#include "../../sim_hal/stability/zero_count.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

class random_rigs
{
  public:
    explicit random_rigs(std::int64_t seed) : generator_(static_cast<std::uint64_t>(seed)) {}

    double between(double low, double high) { return std::uniform_real_distribution<>(low, high)(generator_); }
    double of_size(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
    int below(int n) { return std::uniform_int_distribution<>(0, n - 1)(generator_); }

    /* Every block that a linear rig can have, stable or not, with a dead time of about so many periods. */
    rig next(double dead_periods_max)
    {
        for (;;) {
            constexpr int rates_Hz[] = {50, 100, 200, 250, 400, 500, 1000};
            rig rig;
            rig.bus.ideal = true;
            rig.firmware.loop.rate_Hz = rates_Hz[below(7)];
            const double period_ms = 1e3 / static_cast<double>(rig.firmware.loop.rate_Hz);
            rig.firmware.manipulator.mass_kg = of_size(50.0, 500.0);
            rig.firmware.manipulator.stiffness_N_per_m = of_size(1e3, 3e4);
            rig.firmware.manipulator.damping_N_s_per_m = of_size(10.0, 500.0);
            rig.object.mass_kg = of_size(5.0, 400.0);
            rig.object.stiffness_N_per_m = of_size(10.0, 1e5);
            rig.object.damping_N_s_per_m = of_size(0.1, 500.0);
            rig.sensor.stiffness_N_per_m = of_size(1e5, 5e7);
            rig.sensor.low_pass_order = below(3);
            rig.sensor.low_pass_frequency_Hz = of_size(5.0, 150.0);
            const bool holds = below(2) == 1;
            rig.robot.interpolation = holds ? interpolation::hold : interpolation::linear;
            if (below(2) == 1) {
                rig.robot.transfer_frequency_Hz = of_size(8.0, 60.0);
                rig.robot.transfer_damping_ratio = between(0.3, 1.0);
                rig.firmware.inverse_filter.enabled = below(2);
                rig.firmware.inverse_filter.bandwidth_Hz = 80.0;
            }
            const bool whole = below(3) == 0;
            rig.robot.dead_time_ms = ((holds ? 0.0 : 1.0) + between(0.0, dead_periods_max)) * period_ms;
            rig.sensor.delay_ms = between(0.0, 3.0) * period_ms;
            if (whole) {
                rig.robot.dead_time_ms = period_ms * (1 + below(static_cast<int>(dead_periods_max)));
                rig.sensor.delay_ms = period_ms * below(3);
            } else if (below(2) == 1) {
                rig.sensor.sample_phase_ms = between(0.0, 0.95) * period_ms;
            }
            if (!complete_and_check(rig)) {
                return rig;
            }
        }
    }

  private:
    std::mt19937_64 generator_;
};

int eigenvalues_beyond(const spectrum &spectrum, double magnitude)
{
    return static_cast<int>(std::count_if(spectrum.modes.begin(), spectrum.modes.end(),
                                          [&](const mode &mode) { return std::abs(mode.z) > magnitude; }));
}

} // namespace

TEST_CASE("the characteristic equation has the spectral radius of the one-period map")
{
    REPRODUCIBLE();
    random_rigs rigs(test_seed());
    for (int i = 0; i < 300; i++) {
        const rig rig = rigs.next(i % 30 == 0 ? 390.0 : i % 5 == 0 ? 80.0 : 20.0);
        CAPTURE(i);
        CAPTURE(print_rig(rig));
        dominant_root_finder finder;
        const double radius = finder.spectral_radius(make_loop_equation(rig));
        CHECK(std::abs(radius / loop_spectrum(rig).spectral_radius - 1.0) < 1e-10);
    }
}

/* Random rigs that are changed, so that a zero of A or of B lies on the circle itself. */
template <typename function>
void check_counts_on_the_circle(std::uint64_t seed, function change)
{
    constexpr int count = 200;
    random_rigs rigs(seed);
    int unstable = 0;
    for (int i = 0; i < count; i++) {
        rig rig = rigs.next(i % 5 == 0 ? 80.0 : 20.0);
        change(rig, i);
        CAPTURE(i);
        CAPTURE(print_rig(rig));
        const spectrum all = loop_spectrum(rig);
        CHECK(count_zeros_inside(make_loop_equation(rig), 1.0) == eigenvalues_beyond(all, 1.0));
        CHECK(has_no_zero_inside(make_loop_equation(rig), 1.0) == all.is_stable);
        unstable += !all.is_stable;
    }
    CHECK(unstable > 20);
    CHECK(unstable < count - 20);
}

/* Without its spring, the manipulator has an open-loop pole at z = 1; without its damper, too, two. */
TEST_CASE("zeros inside the unit circle are counted where an open-loop pole lies on it")
{
    REPRODUCIBLE();
    check_counts_on_the_circle(test_seed() + 9, [](rig &changed, int i) {
        changed.firmware.manipulator.stiffness_N_per_m = 0.0;
        if (i % 2 == 0) {
            changed.firmware.manipulator.damping_N_s_per_m = 0.0;
        }
    });
}

/* Without a spring of the object, L has a zero at z = 1. */
TEST_CASE("zeros inside the unit circle are counted where the object floats freely")
{
    REPRODUCIBLE();
    check_counts_on_the_circle(test_seed() + 10, [](rig &changed, int) { changed.object.stiffness_N_per_m = 0.0; });
}

TEST_CASE("the characteristic equation multiplied out is that of its factors")
{
    REPRODUCIBLE();
    random_rigs rigs(test_seed() + 5);
    const auto horner = [](const short_polynomial &p, std::complex<double> w) {
        std::complex<double> sum = 0.0;
        for (int i = p.degree; i >= 0; i--) {
            sum = sum * w + p.coefficients[static_cast<std::size_t>(i)];
        }
        return sum;
    };
    for (int i = 0; i < 100; i++) {
        const rig rig = rigs.next(20.0);
        CAPTURE(i);
        CAPTURE(print_rig(rig));
        const loop_equation equation = make_loop_equation(rig);
        const auto w = std::polar(rigs.between(0.5, 1.5), rigs.between(0.5, 3.0)); /* away from w = 1 */
        const equation_parts parts = evaluate_parts(equation, w);
        CHECK(std::abs(horner(equation.a, w) / parts.a - 1.0) < 1e-9);
        CHECK(std::abs(horner(equation.b, w) / parts.b - 1.0) < 1e-9);
    }
}

TEST_CASE("zeros are counted as dense eigenvalues are")
{
    REPRODUCIBLE();
    random_rigs rigs(test_seed() + 1);
    for (int i = 0; i < 200; i++) {
        const rig rig = rigs.next(i % 30 == 0 ? 200.0 : 20.0);
        CAPTURE(i);
        CAPTURE(print_rig(rig));
        const spectrum spectrum = loop_spectrum(rig);
        for (const double magnitude : {0.7, 0.9, 0.99, 1.0, 1.01}) {
            /* Rounding may put an eigenvalue on the circle to either side of it. */
            const int most = eigenvalues_beyond(spectrum, magnitude * (1.0 - 1e-9));
            const int least = eigenvalues_beyond(spectrum, magnitude * (1.0 + 1e-9));
            const int counted = count_zeros_inside(make_loop_equation(rig), 1.0 / magnitude);
            CHECK(counted >= least);
            CHECK(counted <= most);
        }
    }
}

TEST_CASE("the proof fails when the largest eigenvalue is ignored")
{
    REPRODUCIBLE();
    random_rigs rigs(test_seed() + 2);
    for (int i = 0; i < 100; i++) {
        const rig rig = rigs.next(i % 10 == 0 ? 100.0 : 20.0);
        CAPTURE(i);
        CAPTURE(print_rig(rig));
        const loop_equation equation = make_loop_equation(rig);
        const spectrum spectrum = loop_spectrum(rig);
        const double largest = spectrum.spectral_radius;
        CHECK(has_no_zero_inside(equation, (1.0 - 1e-8) / largest));
        CHECK_FALSE(has_no_zero_inside(equation, (1.0 + 1e-8) / largest));
        for (const mode &mode : spectrum.modes) { /* whichever comes second */
            const double second = std::abs(mode.z);
            if (second < largest * (1.0 - 1e-7)) {
                CHECK_FALSE(has_no_zero_inside(equation, 1.0 / second));
                break;
            }
        }
    }
}

TEST_CASE("a finder that comes from anywhere finds the same")
{
    REPRODUCIBLE();
    random_rigs rigs(test_seed() + 3);
    dominant_root_finder travelled;
    loop_equation_maker maker;
    for (int i = 0; i < 200; i++) {
        const rig rig = rigs.next(i % 10 == 0 ? 100.0 : 20.0);
        CAPTURE(i);
        CAPTURE(print_rig(rig));
        dominant_root_finder fresh;
        const double radius = fresh.spectral_radius(make_loop_equation(rig));
        CHECK(std::abs(travelled.spectral_radius(maker.make(rig)) / radius - 1.0) < 1e-10);
    }
}

TEST_CASE("a map does not depend on threads nor on the order of its points")
{
    REPRODUCIBLE();
    random_rigs rigs(test_seed() + 4);
    for (int i = 0; i < 6; i++) {
        map_request request;
        request.rig = rigs.next(20.0);
        request.kind = map_kind::keys;
        request.x = {"object.mass_kg", 5.0, 400.0, 37};
        request.y = {"robot.dead_time_ms", 1.0, 90.0, 23};
        CAPTURE(print_rig(request.rig));
        const std::vector<double> one = compute_map(request, 1).spectral_radius;
        const std::vector<double> many = compute_map(request, 5).spectral_radius;
        map_request turned = request;
        std::swap(turned.x, turned.y);
        const std::vector<double> columns = compute_map(turned, 2).spectral_radius;
        map_point_setter setter(request);
        for (int row = 0; row < request.y.count; row++) {
            for (int column = 0; column < request.x.count; column++) {
                const int place = row * request.x.count + column;
                const double value = one[static_cast<std::size_t>(place)];
                const bool possible =
                    setter.set(request.x.value(column), request.y.value(row)) == point_state::possible;
                REQUIRE(std::isfinite(value) == possible);
                if (possible) {
                    REQUIRE(many[static_cast<std::size_t>(place)] == value);
                    REQUIRE(std::abs(columns[static_cast<std::size_t>(column * request.y.count + row)] / value -
                                     1.0) < 1e-10);
                }
            }
        }
    }
}

TEST_CASE("a point of a map is the rig whose coupled system lies there")
{
    map_request request;
    request.rig = load_rig("ess", {});
    request.x.name = frequency_ratio_axis;
    request.y.name = damping_ratio_axis;
    for (const map_kind kind : {map_kind::elasticity, map_kind::mass}) {
        request.kind = kind;
        map_point_setter setter(request);
        REQUIRE(setter.set(0.97, 0.11) == point_state::possible);
        const map_point point = map_point_of(setter.rig());
        CHECK(point.frequency_ratio == doctest::Approx(0.97).epsilon(1e-12));
        CHECK(point.damping_ratio == doctest::Approx(0.11).epsilon(1e-12));
        CHECK((setter.rig().object.mass_kg == request.rig.object.mass_kg) == (kind == map_kind::elasticity));
        CHECK(setter.set(0.97, 0.001) == point_state::not_passive);
    }
    request.kind = map_kind::mass;
    CHECK(map_point_setter(request).set(1.2, 0.1) == point_state::not_passive); /* lighter than nothing */
    request.kind = map_kind::elasticity;
    CHECK(map_point_setter(request).set(0.8, 0.1) == point_state::not_passive); /* softer than nothing */
}

} // namespace berth
