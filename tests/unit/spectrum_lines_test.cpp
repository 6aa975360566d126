#include <cmath>
#include <doctest/doctest.h>
#include <vector>

#include "../../firmware/pi.h"
#include "seeded.h"
#include "sim_hal/diagnosis/noise/spectrum_lines.h"

namespace
{

constexpr double sample_period_s = 0.0025;

double normal_number(seeded::engine &random)
{
    const double radius = std::sqrt(-2.0 * std::log(seeded::uniform(random, 1e-300, 1.0)));
    return radius * std::cos(berth::two_pi * seeded::uniform(random, 0.0, 1.0));
}

/* x_n = a x_(n-1) + w_n, of standard deviation 1. */
std::vector<double> coloured_noise(seeded::engine &random, double a, std::size_t rows)
{
    std::vector<double> noise(rows);
    double before = 0.0;
    for (double &value : noise) {
        before = a * before + std::sqrt(1.0 - a * a) * normal_number(random);
        value = before;
    }
    return noise;
}

} // namespace

TEST_CASE("spectrum: noise of any colour has no line, a hum of a third of it has")
{
    SEEDED(random, "spectrum: noise of any colour*");
    for (const double a : {0.0, 0.7, 0.95, -0.8}) {
        CAPTURE(a);
        for (int record = 0; record < 50; record++) {
            std::vector<double> noise = coloured_noise(random, a, 8000);
            CHECK_FALSE(berth::has_line(noise));
            for (std::size_t n = 0; n < noise.size(); n++) {
                noise[n] += 0.47 * std::sin(berth::two_pi * 50.0 * sample_period_s * static_cast<double>(n) + 1.0);
            }
            CHECK(berth::has_line(noise));
            CHECK(berth::strongest_frequency_Hz(noise, sample_period_s) > 0.0);
        }
    }
}

TEST_CASE("spectrum: lines are taken out to a hundredth, and noise keeps what it is")
{
    SEEDED(random, "spectrum: lines are taken out*");
    for (const double frequency_Hz : {0.9, 8.94, 50.03}) {
        CAPTURE(frequency_Hz);
        const std::vector<double> noise = coloured_noise(random, 0.3, 11000);
        std::vector<double> hum = noise;
        for (std::size_t n = 0; n < hum.size(); n++) {
            hum[n] += 5.0 * std::sin(berth::two_pi * frequency_Hz * sample_period_s * static_cast<double>(n) + 0.4);
        }
        std::vector<double> left = hum;
        berth::remove_lines(left, std::vector<berth::row_use>(left.size(), berth::row_use::fit));
        double off = 0.0;
        for (std::size_t n = 0; n < left.size(); n++) {
            off += (left[n] - noise[n]) * (left[n] - noise[n]) / static_cast<double>(left.size());
        }
        CHECK(std::sqrt(off) < 0.05);
        std::vector<double> same = noise;
        berth::remove_lines(same, std::vector<berth::row_use>(same.size(), berth::row_use::fit));
        CHECK(same == noise);
    }
}
