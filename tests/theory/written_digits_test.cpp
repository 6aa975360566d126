#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <doctest/doctest.h>
#include <vector>

#include "../unit/seeded.h"
#include "sim_hal/diagnosis/record/written_digits.h"

using namespace berth;

namespace
{

constexpr std::size_t rows = 4000;

double as_written(const char *format, double value)
{
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return std::strtod(text, nullptr);
}

std::vector<double> written(seeded::engine &random, const char *format)
{
    std::vector<double> made(rows);
    std::generate(made.begin(), made.end(),
                  [&] { return as_written(format, 30.0 * std::pow(seeded::uniform(random, -1.0, 1.0), 3)); });
    return made;
}

} // namespace

TEST_CASE("written digits: so many behind the point are one unit, whatever the size")
{
    SEEDED(random, "written digits: so many behind the point*");
    for (const double unit : units_of_last_digits(written(random, "%.3f"))) {
        CHECK(unit == doctest::Approx(1e-3));
    }
}

TEST_CASE("written digits: so many in all are a unit that grows with the value")
{
    SEEDED(random, "written digits: so many in all*");
    const std::vector<double> values = written(random, "%.4g");
    const std::vector<double> units = units_of_last_digits(values);
    for (std::size_t n = 0; n < rows; n++) {
        if (std::abs(values[n]) >= 0.1) { /* of smaller ones there are few */
            CHECK(units[n] == doctest::Approx(std::pow(10.0, std::floor(std::log10(std::abs(values[n]))) - 3.0)));
        }
    }
}

TEST_CASE("written digits: what has all of them, and levels that somebody chose, are exact")
{
    SEEDED(random, "written digits: what has all*");
    std::vector<double> levels(rows);
    for (std::size_t n = 0; n < rows; n++) {
        levels[n] = 2.5 * std::floor(4.0 * std::sin(0.01 * static_cast<double>(n)));
    }
    for (const auto &values : {written(random, "%.17g"), levels}) {
        const std::vector<double> units = units_of_last_digits(values);
        CHECK(std::count(units.begin(), units.end(), 0.0) == static_cast<std::ptrdiff_t>(rows));
    }
}
