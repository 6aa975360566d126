/* Growth that a run shows against growth that the eigenvalues predict, for rigs drawn at random. */
#include <algorithm>
#include <cmath>
#include <complex>
#include <doctest/doctest.h>
#include <Eigen/Core>

#include "../../sim_hal/effects/effect.h"
#include "../../sim_hal/hil/random.h"
#include "../../sim_hal/solver/decompositions.h"
#include "../../sim_hal/stability/spectrum.h"
#include "../support/closed_loop.h"
#include "../support/random_rigs.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

constexpr int rig_count = cases_to_draw(200);
constexpr double run_s = 40.0;

/* Frames have steps of 10 pm and 0.1 uN: what they add up to in the position. */
constexpr double noise_m = 3e-11;

/* A mode is seen if it stands out of the noise by this factor at the end of the window where it is largest. */
constexpr double visible = 1e3;

/* Position while the rig runs free of limits, released from as far out as the expected growth lets it be. At first,
 * for no longer than it takes to grow by e, it is shaken a little, because a release alone may hardly stir the mode
 * that will rule. */
std::vector<double> run_free(rig rig, double expected_growth_per_s, random_stream &random)
{
    const double growth_a_tick = std::abs(expected_growth_per_s) * config_period_s(&rig.firmware);
    const int shaken_ticks = static_cast<int>(std::min(60.0, 1.0 / growth_a_tick));
    constexpr double shake = 2e-3;
    const double largest_m = std::min(0.5, 1e4 / rig.object.stiffness_N_per_m);
    const double start_m = largest_m * std::max(1e-6, std::exp(-run_s * std::max(0.0, expected_growth_per_s)));
    rig.run.duration_s = run_s;
    rig.run.release_s = 0.0;
    rig.firmware.limits = {-5.0, 5.0, 1e6, 1e12};
    rig.firmware.sensor_channel.force_limit_N = 5.4e4;
    rig.firmware.reflex = without_reflexes(rig.firmware.reflex);
    rig.firmware.manipulator.initial_position_m = start_m;
    REQUIRE(!complete_and_check(rig));
    closed_loop loop(rig);
    loop.start();
    for (int i = 0; i < shaken_ticks; i++) {
        REQUIRE(loop.tick());
        loop.app().manipulator.position_m += shake * start_m * (random.uniform() - 0.5);
    }
    return free_motion_m(loop);
}

struct seen_mode {
    double growth_per_s;
    double height_m; /* at the end of the window where it is largest */
};

/* Modes in a window of samples, by ESPRIT: the signal's Hankel matrix has one singular vector for each mode, and
 * shifting them by a sample multiplies each mode by its z. Growth does not mind aliasing. */
std::vector<seen_mode> modes_in(const Eigen::VectorXd &x, double step_s)
{
    const Eigen::Index rows = x.size() / 2;
    Eigen::MatrixXd hankel(rows, x.size() - rows + 1);
    for (Eigen::Index i = 0; i < hankel.cols(); i++) {
        hankel.col(i) = x.segment(i, rows);
    }
    /* Singular values s and vectors of H: [0 H; H^T 0] (u, v) = s (u, v), and |u| = |v|. */
    Eigen::MatrixXd both = Eigen::MatrixXd::Zero(x.size() + 1, x.size() + 1);
    both.topRightCorner(rows, hankel.cols()) = hankel;
    both.bottomLeftCorner(hankel.cols(), rows) = hankel.transpose();
    const eigenpairs singular = symmetric_eigenpairs(both);
    const double floor = std::max(noise_m * static_cast<double>(rows), 1e-13 * singular.values.maxCoeff());
    const Eigen::Index count = std::min<Eigen::Index>((singular.values.array() > floor).count(), rows - 1);
    const Eigen::MatrixXd u = std::sqrt(2.0) * singular.vectors.topRightCorner(rows, count);
    const Eigen::VectorXcd z = eigenvalues(least_squares_solution(u.topRows(rows - 1), u.bottomRows(rows - 1)));

    /* Amplitudes: powers counted from the end where each is largest, so that none overflows. */
    Eigen::MatrixXcd powers(x.size(), count);
    for (Eigen::Index j = 0; j < count; j++) {
        for (Eigen::Index i = 0; i < x.size(); i++) {
            const double exponent = static_cast<double>(std::abs(z(j)) > 1.0 ? i - x.size() + 1 : i);
            powers(i, j) = std::pow(z(j), exponent);
        }
    }
    Eigen::MatrixXd parts(2 * x.size(), 2 * count); /* real parts before imaginary ones */
    parts << powers.real(), -powers.imag(), powers.imag(), powers.real();
    Eigen::VectorXd wanted = Eigen::VectorXd::Zero(2 * x.size());
    wanted.head(x.size()) = x;
    const Eigen::VectorXd amplitudes = least_squares_solution(parts, wanted);
    std::vector<seen_mode> modes;
    for (Eigen::Index j = 0; j < count; j++) {
        modes.push_back({std::log(std::abs(z(j))) / step_s, std::hypot(amplitudes(j), amplitudes(count + j))});
    }
    return modes;
}

/* Growth of the mode that grows most (decays least), from all of the run that is above the noise but its very
 * beginning. */
double measured_growth_per_s(const std::vector<double> &position_m, double period_s)
{
    std::size_t end = position_m.size();
    while (end > 0 && std::abs(position_m[end - 1]) < 10.0 * visible * noise_m) {
        end--;
    }
    constexpr std::size_t window_samples = 240;
    const std::size_t begin = end / 10;
    const std::size_t step = std::max<std::size_t>(1, (end - begin) / window_samples);
    const auto count = static_cast<Eigen::Index>((end - begin) / step);
    REQUIRE(count >= 6);
    Eigen::VectorXd window(count);
    for (Eigen::Index i = 0; i < count; i++) {
        window(i) = position_m[begin + step * static_cast<std::size_t>(i)];
    }
    double growth_per_s = -1e9;
    for (const seen_mode &mode : modes_in(window, period_s * static_cast<double>(step))) {
        if (mode.height_m > visible * noise_m) {
            growth_per_s = std::max(growth_per_s, mode.growth_per_s);
        }
    }
    return growth_per_s;
}

/* Relative difference between measured and predicted growth. */
double growth_error(const rig &rig, random_stream &random, const std::string &name)
{
    const spectrum predicted = loop_spectrum(rig);
    const std::vector<double> x = run_free(rig, predicted.growth_per_s, random);
    const double measured_per_s = measured_growth_per_s(x, config_period_s(&rig.firmware));
    INFO(name, ": ", rig.firmware.loop.rate_Hz, " Hz, ", x.size(), " ticks; predicted ", predicted.growth_per_s,
         " /s, measured ", measured_per_s, " /s; modes predicted next ", predicted.modes[1].growth_per_s, ", ",
         predicted.modes[2].growth_per_s, " /s");
    const double error = std::abs(measured_per_s / predicted.growth_per_s - 1.0);
    CHECK(error < 1e-2);
    return error;
}

} // namespace

TEST_CASE("200 random rigs grow in a run as the eigenvalues say, within 1 %")
{
    REPRODUCIBLE();
    rig_draw rigs(test_seed());
    random_stream random(test_seed(), 4);
    int unstable = 0;
    double worst = 0.0;
    for (int i = 0; i < rig_count; i++) {
        const rig rig = rigs.draw();
        unstable += !loop_spectrum(rig).is_stable;
        worst = std::max(worst, growth_error(rig, random, "rig " + std::to_string(i)));
    }
    MESSAGE(unstable << " of " << rig_count << " unstable; largest relative difference " << worst);
}

TEST_CASE("random rigs with linear effects grow in a run as the eigenvalues say, within 1 %")
{
    REPRODUCIBLE();
    constexpr int rigs_each = 5;
    rig_draw rigs(test_seed());
    random_stream random(test_seed(), 5);
    const auto between = [&](double low, double high) { return low * std::pow(high / low, random.uniform()); };
    double worst = 0.0;
    for (int i = 0; i < 4 * rigs_each; i++) {
        rig rig = rigs.draw();
        const int kind = i % 4; /* robot's lag, sensor's lag, second mode, all of them */
        if (kind == 0 || kind == 3) {
            set_number(rig, "robot.lag_ms", between(1.0, 30.0));
        }
        if (kind == 1 || kind == 3) {
            set_number(rig, "sensor.lag_ms", between(1.0, 30.0));
        }
        if (kind >= 2) {
            set_number(rig, "object.second_mass_kg", rig.object.mass_kg * between(0.03, 0.5));
            set_number(rig, "object.second_frequency_Hz", between(1.0, 20.0));
            set_number(rig, "object.second_damping_ratio", between(0.01, 0.3));
        }
        worst = std::max(worst, growth_error(rig, random, "kind " + std::to_string(kind)));
    }
    MESSAGE("largest relative difference " << worst);
}

} // namespace berth
