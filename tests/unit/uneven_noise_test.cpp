/* What is told of noise that may follow the motion, where the truth is known. */
#include <cmath>
#include <doctest/doctest.h>
#include <random>

#include "sim_hal/diagnosis/noise/uneven_noise.h"

using namespace berth;

namespace
{

constexpr double period_s = 0.0025;
constexpr double noise_m = 1e-5;
constexpr std::size_t half_swing = 1130; /* rows */

/* A triangle of 1 mm, and noise that is `calmer` by so much of its variance about the turning points. */
std::vector<std::string> told_of_triangle(double calmer)
{
    std::mt19937 draw(5);
    std::normal_distribution<double> normal;
    record data;
    data.period_s = period_s;
    block_diagnosis robot;
    robot.block = block::robot;
    for (std::size_t n = 0; n < 40 * half_swing; n++) {
        const double place = static_cast<double>(n % half_swing) / half_swing;
        const double way_m = 1e-3 * (n / half_swing % 2 == 0 ? place : 1.0 - place);
        const bool turns = place < 0.05 || place > 0.95;
        robot.error_after.push_back(noise_m * std::sqrt(turns ? 1.0 - calmer : 1.0) * normal(draw));
        robot.uses.push_back(row_use::fit);
        data.robot_position_m.push_back(way_m + robot.error_after.back());
    }
    robot.fit_rms.after = robot.floor.rms = noise_m;
    return noise_that_follows_motion({robot}, data);
}

} // namespace

TEST_CASE("of a constant speed no growth with the velocity is told")
{
    CHECK(told_of_triangle(0.0).empty());
    for (const std::string &line : told_of_triangle(0.95)) {
        INFO(line);
        CHECK(line.find("velocity") == std::string::npos);
    }
}
