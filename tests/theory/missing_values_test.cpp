#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "sim_hal/diagnosis/record/missing_values.h"

using namespace berth;

namespace
{

constexpr std::size_t rows_count = 4000;
constexpr std::size_t lost_at = 1000; /* and three rows behind it */
constexpr std::size_t lost_count = 4;

/* How far off the middle of a burst is told of a signal, given by its row. */
double worst_of_burst(const std::function<double(double)> &signal)
{
    std::vector<double> place;
    std::vector<double> read;
    for (std::size_t n = 0; n < rows_count; n++) {
        if (n < lost_at || n >= lost_at + lost_count) {
            place.push_back(static_cast<double>(n));
            read.push_back(signal(place.back()));
        }
    }
    missing_values values(read, place);
    double worst = 0.0;
    for (std::size_t row = 1; row <= lost_count; row++) {
        const double told = values.at(lost_at, lost_count, row, {0, read.size()});
        worst = std::max(worst, std::abs(told - signal(static_cast<double>(lost_at + row - 1))));
    }
    return worst;
}

} // namespace

TEST_CASE("A motion of 5 Hz is put back far better than a cubic could")
{
    const double rad_per_row = 2.0 * std::acos(-1.0) * 5.0 / 400.0;
    /* A cubic errs by a^4 times 3.5 * 2.5 * 2.5 * 3.5 / 24 in the middle, a its swing in a row. */
    const double cubic = std::pow(rad_per_row, 4) * 3.5 * 2.5 * 2.5 * 3.5 / 24.0;
    CHECK(worst_of_burst([&](double row) { return std::sin(rad_per_row * row); }) < 0.01 * cubic);
}

TEST_CASE("A staircase is put back as one between the two rows about the burst")
{
    const auto stair = [](double row) { return std::fmod(std::floor(row / 7.0) * 0.618, 1.0); };
    CHECK(worst_of_burst(stair) < 1.0); /* the largest of its steps: nothing swings over */
}

TEST_CASE("Of noise a burst is told no worse than by the mean of the two rows about it")
{
    constexpr unsigned seed = 7;
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, 1.0);
    std::vector<double> place;
    std::vector<double> read;
    for (std::size_t n = 0; n < rows_count; n++) {
        place.push_back(static_cast<double>(n));
        read.push_back(noise(random));
    }
    missing_values values(read, place);
    values.at(lost_at, 2, 1, {0, rows_count});
    CHECK(values.error_rms() == doctest::Approx(std::sqrt(1.0 + 5.0 / 9.0)).epsilon(0.1)); /* 1/3 and 2/3 of them */
}

TEST_CASE("At the ends of a part only its own rows are asked")
{
    std::vector<double> place;
    std::vector<double> read;
    for (std::size_t n = 0; n < 100; n++) {
        place.push_back(static_cast<double>(n < 51 ? n : n + 2));
        read.push_back(n < 50 ? 1e6 : place.back());
    }
    missing_values values(read, place);
    CHECK(values.at(51, 2, 1, {50, 100}) == doctest::Approx(51.0));
}
