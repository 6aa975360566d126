/* What a fit knows of its parameters together, against the normal distribution written out. */
#include <cmath>
#include <doctest/doctest.h>
#include <Eigen/Core>
#include <random>
#include <vector>

#include "../../sim_hal/diagnosis/fit/prior.h"
#include "../../sim_hal/effects/effect.h"
#include "../../sim_hal/solver/factors.h"
#include "seeded.h"

using namespace berth;

namespace
{

constexpr std::size_t count = 4;
constexpr const char *names[count] = {"robot.dead_time_ms", "robot.lag_ms", "object.mass_kg",
                                      "object.stiffness_N_per_m"};

struct known_parameters {
    std::vector<free_parameter> alone;
    Eigen::MatrixXd correlation;
    Eigen::MatrixXd covariance;
};

/* The first two nearly make up for each other. */
known_parameters drawn(seeded::engine &random)
{
    std::normal_distribution<double> normal;
    Eigen::MatrixXd mixed = Eigen::MatrixXd::Identity(count, count);
    mixed = mixed.unaryExpr([&](double own) { return own + seeded::uniform(random, -0.2, 0.2); });
    mixed.row(1) = -mixed.row(0) + 1e-2 * mixed.row(1);
    Eigen::MatrixXd covariance = mixed * mixed.transpose();
    known_parameters made;
    const Eigen::VectorXd sd = covariance.diagonal().cwiseSqrt();
    made.correlation = sd.cwiseInverse().asDiagonal() * covariance * sd.cwiseInverse().asDiagonal();
    const Eigen::Vector4d units(0.1, 0.02, 3.0, 400.0);
    made.covariance = units.asDiagonal() * made.correlation * units.asDiagonal();
    for (std::size_t i = 0; i < count; i++) {
        made.alone.push_back(
            {find_key(names[i]), 0.0, 0.0, 10.0 + normal(random), units(static_cast<Eigen::Index>(i))});
    }
    return made;
}

/* A rig whose kept parameters are off by about their deviations, the others as expected. */
rig moved(const known_parameters &known, const std::vector<bool> &kept, seeded::engine &random, Eigen::VectorXd &off)
{
    std::normal_distribution<double> normal;
    off = Eigen::VectorXd::Zero(count);
    rig made;
    for (std::size_t i = 0; i < count; i++) {
        const auto k = static_cast<Eigen::Index>(i);
        off(k) = kept[i] ? normal(random) * known.alone[i].expected_sd : 0.0;
        set_number(made, names[i], known.alone[i].expected + off(k));
    }
    return made;
}

double sum_of_strains(const std::vector<free_parameter> &priors, const rig &rig)
{
    double sum = 0.0;
    for (const free_parameter &prior : priors) {
        sum += std::pow(strain_of(prior, rig), 2);
    }
    return sum;
}

} // namespace

TEST_CASE("prior: the strains of parameters known together sum up to the exponent of their normal distribution")
{
    SEEDED(random, "prior:*");
    const std::vector<bool> all(count, true);
    for (int i = 0; i < 50; i++) {
        const known_parameters known = drawn(random);
        Eigen::VectorXd off;
        const rig rig = moved(known, all, random, off);
        const double expected = off.dot(solution(known.covariance, off).col(0));
        const auto priors = known_together(known.alone, known.correlation, all);
        REQUIRE(priors.size() == count);
        CHECK(sum_of_strains(priors, rig) == doctest::Approx(expected).epsilon(1e-3));
        for (std::size_t k = 0; k < count; k++) {
            CHECK(priors[k].expected_sd == doctest::Approx(known.alone[k].expected_sd).epsilon(1e-4));
            CHECK(priors[k].high - priors[k].low == doctest::Approx(8.0 * priors[k].expected_sd));
        }
    }
}

TEST_CASE("prior: what is not kept stays as expected, and says so much more of what nearly makes up for it")
{
    SEEDED(random, "prior:*");
    const std::vector<bool> kept{true, false, true, true};
    for (int i = 0; i < 50; i++) {
        const known_parameters known = drawn(random);
        Eigen::VectorXd off;
        const rig rig = moved(known, kept, random, off);
        const auto priors = known_together(known.alone, known.correlation, kept);
        REQUIRE(priors.size() == count - 1);
        const double expected = off.dot(solution(known.covariance, off).col(0));
        CHECK(sum_of_strains(priors, rig) == doctest::Approx(expected).epsilon(1e-3));
        CHECK(priors[0].expected_sd < 0.5 * known.alone[0].expected_sd);
    }
}

TEST_CASE("prior: slopes of the strains are their finite differences")
{
    SEEDED(random, "prior:*");
    const std::vector<bool> all(count, true);
    const known_parameters known = drawn(random);
    Eigen::VectorXd off;
    const rig here = moved(known, all, random, off);
    const auto priors = known_together(known.alone, known.correlation, all);
    for (const free_parameter &prior : priors) {
        for (std::size_t k = 0; k < count; k++) {
            rig there = here;
            const double step = known.alone[k].expected_sd;
            set_number(there, names[k], value_of(here, names[k]) + step);
            const double difference = (strain_of(prior, there) - strain_of(prior, here)) / step;
            CHECK(strain_slope(prior, find_key(names[k])) == doctest::Approx(difference).epsilon(1e-6));
        }
    }
}

TEST_CASE("prior: a parameter known by itself leans on nothing")
{
    const free_parameter alone{find_key("robot.lag_ms"), 0.0, 4.0, 2.0, 0.5};
    rig rig;
    set_number(rig, "robot.lag_ms", 3.0);
    CHECK(strain_of(alone, rig) == doctest::Approx(2.0));
    CHECK(strain_slope(alone, find_key("robot.lag_ms")) == doctest::Approx(2.0));
    CHECK(strain_slope(alone, find_key("object.mass_kg")) == 0.0);
}
