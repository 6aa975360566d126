#include <cmath>
#include <doctest/doctest.h>
#include <vector>

#include "../../firmware/pi.h"
#include "seeded.h"
#include "sim_hal/diagnosis/noise/noise.h"

namespace
{

double normal(seeded::engine &random)
{
    const double radius = std::sqrt(-2.0 * std::log(seeded::uniform(random, 1e-300, 1.0)));
    return radius * std::cos(berth::two_pi * seeded::uniform(random, 0.0, 1.0));
}

/* White noise, and a slow one of first order with a time constant of `rows_long` rows. */
struct sensor_noise {
    double white;
    double slow;
    double rows_long;

    double decay() const { return std::exp(-1.0 / rows_long); }

    std::vector<double> draw(seeded::engine &random, std::size_t rows) const
    {
        std::vector<double> made(rows);
        double state = slow * normal(random);
        for (double &value : made) {
            value = state + white * normal(random);
            state = decay() * state + slow * std::sqrt(1.0 - decay() * decay()) * normal(random);
        }
        return made;
    }

    /* Of what is new in each row: the positive root of the filter's Riccati equation, which is quadratic here. */
    double sigma() const
    {
        const double r = white * white;
        const double q = slow * slow * (1.0 - decay() * decay());
        const double b = q - r * (1.0 - decay() * decay());
        const double predicted = 0.5 * (b + std::sqrt(b * b + 4.0 * q * r));
        return std::sqrt(predicted + r);
    }
};

double correlation(const std::vector<double> &x, std::size_t lag)
{
    double sum = 0.0;
    for (std::size_t n = lag; n < x.size(); n++) {
        sum += x[n] * x[n - lag];
    }
    return sum / berth::sum_of_squares(x);
}

} // namespace

TEST_CASE("noise: a slow part beside white noise is known by what is new in each row, and whitened at every lag")
{
    SEEDED(random, "noise: a slow part*");
    constexpr std::size_t rows = 20000;
    const std::vector<berth::row_use> all(rows, berth::row_use::fit);
    for (const sensor_noise &noise :
         {sensor_noise{0.019, 0.017, 92.0}, sensor_noise{1.0, 0.5, 300.0}, sensor_noise{1.0, 2.0, 30.0}}) {
        CAPTURE(noise.rows_long);
        const std::vector<double> error = noise.draw(random, rows);
        const berth::noise_model found = berth::estimate_noise(error, all);
        /* The estimate of a standard deviation from that many rows is off by 0.5 %. */
        CHECK(found.sigma == doctest::Approx(noise.sigma()).epsilon(0.025));
        std::vector<double> white;
        berth::whiten(found, error, all, berth::row_use::fit, white);
        CHECK(white.size() + 8 >= rows);
        CHECK(berth::sum_of_squares(white) / static_cast<double>(rows) == doctest::Approx(1.0).epsilon(0.03));
        double sum = 0.0; /* over neighbouring lags: what a regression over eight rows leaves is small at each */
        for (std::size_t lag = 1; lag <= 100; lag++) {
            sum += correlation(white, lag);
        }
        const double sd = std::sqrt(100.0 / static_cast<double>(rows));
        CHECK(std::abs(sum) < 4.5 * sd);
    }
}

TEST_CASE("noise: across rows that are out of use the slow part is predicted, not forgotten")
{
    SEEDED(random, "noise: across rows*");
    constexpr std::size_t rows = 40000;
    const sensor_noise noise{0.3, 2.0, 400.0};
    const std::vector<double> error = noise.draw(random, rows);
    std::vector<berth::row_use> uses(rows, berth::row_use::fit);
    for (std::size_t n = 0; n < rows; n++) {
        if (n % 20 < 4) {
            uses[n] = berth::row_use::none;
        }
    }
    const berth::noise_model found =
        berth::estimate_noise(error, std::vector<berth::row_use>(rows, berth::row_use::fit));
    REQUIRE(found.slow_gain > 0.0);
    std::vector<double> white;
    berth::whiten(found, error, uses, berth::row_use::fit, white);
    CHECK(white.size() == rows - rows / 5);
    double first = 0.0; /* sum of squares of the rows that follow a gap */
    for (std::size_t i = 0; i < white.size(); i += 16) {
        first += white[i] * white[i];
    }
    /* Each row's own uncertainty counts, so that those after a gap are as white as the others. */
    CHECK(first / (static_cast<double>(rows) / 20.0) == doctest::Approx(1.0).epsilon(0.12));
    CHECK(berth::sum_of_squares(white) / static_cast<double>(white.size()) == doctest::Approx(1.0).epsilon(0.05));
}

TEST_CASE("noise: white noise stays white, and a regression keeps what only it describes")
{
    SEEDED(random, "noise: white noise*");
    constexpr std::size_t rows = 20000;
    const std::vector<berth::row_use> all(rows, berth::row_use::fit);
    std::vector<double> error(rows);
    for (double &value : error) {
        value = 3.0 * normal(random);
    }
    CHECK_FALSE(berth::estimate_noise(error, all).has_colour());
    /* A resonance: poles off the real axis, which no noise of first order has. */
    for (std::size_t n = 2; n < rows; n++) {
        error[n] = 1.6 * error[n - 1] - 0.9 * error[n - 2] + normal(random);
    }
    const berth::noise_model found = berth::estimate_noise(error, all);
    CHECK(found.slow_gain == 0.0);
    REQUIRE(found.ar.size() >= 2);
    CHECK(found.ar[0] == doctest::Approx(1.6).epsilon(0.03));
    CHECK(found.sigma == doctest::Approx(1.0).epsilon(0.025));
}

TEST_CASE("noise: third differences know of the noise beside a motion that is a thousand times larger")
{
    constexpr std::size_t rows = 4000;
    SEEDED(random, "noise: third*");
    std::vector<double> error(rows);
    for (std::size_t n = 0; n < rows; n++) {
        const double jump = n % 500 < 250 ? 0.0 : 3.0; /* a few steps do not count */
        error[n] = 5.0 * std::sin(0.01 * static_cast<double>(n)) + jump + 0.005 * normal(random);
    }
    const std::vector<berth::row_use> uses(rows, berth::row_use::fit);
    const berth::noise_model found = berth::noise_of_differences(error, uses);
    CHECK(found.rms == doctest::Approx(0.005).epsilon(0.1));
    CHECK(berth::rms_ci95(found, uses) ==
          doctest::Approx(1.96 * found.rms / std::sqrt(2.0 * (rows - 3))).epsilon(0.01));
}

TEST_CASE("noise: the rms of a slow noise is known as well as its squared autocorrelation says")
{
    constexpr double keeps = 0.9; /* 1 + 2 sum of keeps^(2k) = (1 + keeps^2) / (1 - keeps^2) = 9.526 */
    constexpr std::size_t rows = 10000;
    const berth::noise_model slow{{keeps}, std::sqrt(1.0 - keeps * keeps), 1.0, 1.0, rows};
    CHECK(berth::rms_ci95(slow, {}) == doctest::Approx(1.96 * std::sqrt(0.5 * 9.5263 / rows)).epsilon(1e-3));
}

TEST_CASE("noise: of an unstable regression the rms is known as from one fact, and never not a number")
{
    const berth::noise_model unstable{{2.5}, 1.0, 3.0, 1.0, 100};
    CHECK(berth::rms_ci95(unstable, {}) == doctest::Approx(1.96 * 3.0 * std::sqrt(0.5)));
}
