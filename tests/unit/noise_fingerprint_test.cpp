#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

#include "../../firmware/pi.h"
#include "seeded.h"
#include "sim_hal/diagnosis/record/noise_fingerprint.h"

namespace
{

constexpr double sample_period_s = 0.0025;
constexpr std::size_t record_rows = 6000;

using series = std::vector<double>;

double normal_value(seeded::engine &random)
{
    const double radius = std::sqrt(-2.0 * std::log(seeded::uniform(random, 1e-300, 1.0)));
    return radius * std::cos(berth::two_pi * seeded::uniform(random, 0.0, 1.0));
}

series noisy(series values, double sd, seeded::engine &random)
{
    for (double &value : values) {
        value += sd * normal_value(random);
    }
    return values;
}

series rounded(series values, double unit)
{
    for (double &value : values) {
        value = unit * std::round(value / unit);
    }
    return values;
}

/* Swings of 0.01 that answer late to those of the cause. */
series swings(double late_s = 0.0, double turns_per_s = 0.7)
{
    series values(record_rows);
    for (std::size_t n = 0; n < record_rows; n++) {
        const double turns = turns_per_s * (sample_period_s * static_cast<double>(n) - late_s);
        values[n] = 0.01 * std::sin(berth::two_pi * turns) + 0.003 * std::sin(berth::two_pi * 3.0 * turns + 1.0);
    }
    return values;
}

std::optional<berth::copy_found> copy_of(const series &first, const series &other, const series &cause = {})
{
    return berth::find_copy({{first, cause, {}}}, {{other, cause, {}}});
}

} // namespace

TEST_CASE("noise fingerprint: a copy is known however it was turned, cut, scaled, rounded and made noisy")
{
    SEEDED(random, "noise fingerprint: a copy is known*");
    for (const double noise : {1e-7, 1e-6, 1e-4}) {
        const series first = noisy(swings(0.0175), noise, random);
        for (int form = 0; form < 32; form++) {
            CAPTURE(noise);
            CAPTURE(form);
            const bool is_backwards = (form & 1) != 0;
            const std::ptrdiff_t from = (form & 2) != 0 ? 2000 : 0;
            const double factor = ((form & 4) != 0 ? 1.5 : 1.0) * ((form & 8) != 0 ? -1.0 : 1.0);
            const auto turned = [&](const series &whole) {
                series part(whole.begin() + from, whole.end());
                for (double &value : part) {
                    value *= factor;
                }
                return is_backwards ? series(part.rbegin(), part.rend()) : part;
            };
            const series values = turned(first);
            const series copied = (form & 16) != 0 ? rounded(values, noise) : noisy(values, 0.4 * noise, random);
            for (const series &cause : {series(), swings()}) {
                const auto found =
                    berth::find_copy({{first, cause, {}}}, {{copied, cause.empty() ? cause : turned(cause), {}}});
                REQUIRE(found);
                CHECK(found->is_backwards == is_backwards);
                CHECK(found->begin == (is_backwards ? std::ptrdiff_t{record_rows} - 1 : from));
                CHECK(found->factor == doctest::Approx(factor).epsilon(0.05));
            }
        }
    }
}

TEST_CASE("noise fingerprint: what is measured twice is no copy, whatever its steps and its noise")
{
    SEEDED(random, "noise fingerprint: what is measured twice*");
    for (const double noise : {0.0, 1e-9, 1e-7, 1e-5, 1e-3}) {
        for (const double step : {1e-8, 1e-6, 2e-5, 1e-3}) {
            for (const double turns_per_s : {0.7, 1.0 / (sample_period_s * record_rows), 40.0}) {
                CAPTURE(noise);
                CAPTURE(step);
                CAPTURE(turns_per_s);
                const series cause = swings(0.0, turns_per_s);
                const series motion = swings(0.0175, turns_per_s);
                const series first = rounded(noisy(motion, noise, random), step);
                const series again = rounded(noisy(motion, noise, random), step);
                CHECK_FALSE(copy_of(first, again, cause));
                CHECK_FALSE(copy_of(first, again));
                CHECK_FALSE(copy_of(noisy(motion, noise, random), again, cause));
            }
        }
    }
}

TEST_CASE("noise fingerprint: what a command of white noise makes a robot do again is no noise")
{
    SEEDED(random, "noise fingerprint: what a command of white noise*");
    const series cause = noisy(series(record_rows, 0.0), 1e-3, random);
    series motion(record_rows, 0.0);
    for (std::size_t n = 6; n < record_rows; n++) {
        motion[n] = 0.3 * motion[n - 1] + 0.4 * cause[n - 5] + 0.3 * cause[n - 6];
    }
    CHECK_FALSE(copy_of(noisy(motion, 1e-6, random), noisy(motion, 1e-6, random), cause));
    CHECK_FALSE(copy_of(motion, motion, cause));
}

/* What a stiff sensor feels of a robot whose dead band of 0.15 mm makes stairs of the motion. */
series felt_on_stairs(const series &command)
{
    series felt(command.size(), 0.0);
    double position = command.front();
    for (std::size_t n = 2; n < command.size(); n++) {
        const double before = position;
        if (std::abs(command[n] - position) > 1.5e-4) {
            position = command[n];
        }
        felt[n] = 1.3 * felt[n - 1] - 0.8 * felt[n - 2] + 2e5 * (position - before);
    }
    return felt;
}

TEST_CASE("noise fingerprint: stairs that a dead band makes twice are no noise, a copy of them is one")
{
    SEEDED(random, "noise fingerprint: stairs*");
    series command(record_rows);
    for (std::size_t n = 0; n < record_rows; n++) {
        const double time_s = sample_period_s * static_cast<double>(n);
        command[n] = 0.01 * std::sin(berth::two_pi * (0.1 + 0.05 * time_s) * time_s);
    }
    for (const double noise_N : {1.0, 2.0, 3.0}) {
        CAPTURE(noise_N);
        const series first = noisy(felt_on_stairs(command), noise_N, random);
        CHECK_FALSE(copy_of(first, noisy(felt_on_stairs(command), noise_N, random), command));
        CHECK(copy_of(first, first, command));
        CHECK(copy_of(first, rounded(first, noise_N), command));
        CHECK(copy_of(first, noisy(first, 0.02 * noise_N, random), command));
    }
}

TEST_CASE("noise fingerprint: stairs that a command makes again, turned over and for most of the way, are no noise")
{
    SEEDED(random, "noise fingerprint: stairs that a command*");
    series command(record_rows);
    series other_command(record_rows);
    for (std::size_t n = 0; n < record_rows; n++) {
        const double time_s = sample_period_s * static_cast<double>(n);
        command[n] = 0.01 * std::sin(berth::two_pi * (0.1 + 0.05 * time_s) * time_s);
        const bool goes_on_otherwise = n > record_rows * 17 / 20;
        other_command[n] = goes_on_otherwise ? 0.01 * std::sin(berth::two_pi * 0.9 * time_s) : -command[n];
    }
    for (const double noise_N : {1.0, 2.0}) {
        CAPTURE(noise_N);
        const series first = noisy(felt_on_stairs(command), noise_N, random);
        const series other = noisy(felt_on_stairs(other_command), noise_N, random);
        CHECK_FALSE(berth::find_copy({{first, command, {}}}, {{other, other_command, {}}}));
    }
}

TEST_CASE("noise fingerprint: rest, a limit and rows that were filled in are no noise")
{
    SEEDED(random, "noise fingerprint: rest*");
    series limited = swings();
    for (double &value : limited) {
        value = std::clamp(value, -0.004, 0.004);
    }
    CHECK_FALSE(copy_of(limited, limited));
    CHECK_FALSE(copy_of(series(record_rows, 0.01), series(record_rows, 0.01)));
    std::vector<std::uint8_t> guessed(record_rows, 0);
    std::fill(guessed.begin() + 100, guessed.end() - 100, std::uint8_t{1});
    const series noise = noisy(limited, 1e-5, random);
    CHECK(copy_of(noise, noise));
    CHECK_FALSE(berth::find_copy({{noise, {}, guessed}}, {{noise, {}, guessed}}));
}

TEST_CASE("noise fingerprint: a column that was measured again speaks for all, but for one that is the same")
{
    SEEDED(random, "noise fingerprint: a column that was measured again*");
    const auto is_copy = [](const series &force, const series &robot, const series &other_force,
                            const series &other_robot) {
        return berth::find_copy({{force, {}, {}}, {robot, {}, {}}}, {{other_force, {}, {}}, {other_robot, {}, {}}})
            .has_value();
    };
    const series robot = noisy(swings(), 1e-6, random);
    const series force = noisy(swings(0.01, 1.3), 1e-5, random);
    const series force_again = noisy(swings(0.01, 1.3), 1e-5, random);
    CHECK(is_copy(force, robot, force, robot));
    CHECK_FALSE(is_copy(force, robot, force_again, noisy(robot, 0.4e-6, random)));
    CHECK(is_copy(force, robot, force_again, robot));
    CHECK(is_copy(force, robot, force, noisy(swings(), 1e-6, random)));
}

TEST_CASE(
    "noise fingerprint: a copy of the robot's noise is one, however jerky the force; jerks of the robot are none")
{
    SEEDED(random, "noise fingerprint: a copy of the robot's noise*");
    series command(record_rows);
    series stairs(record_rows);
    double position = 0.0;
    for (std::size_t n = 0; n < record_rows; n++) {
        const double time_s = sample_period_s * static_cast<double>(n);
        command[n] = 0.01 * std::sin(berth::two_pi * (0.1 + 0.05 * time_s) * time_s);
        position = std::abs(command[n] - position) > 1.5e-4 ? command[n] : position;
        stairs[n] = position;
    }
    const series force = felt_on_stairs(command);
    const auto is_copy = [&](const series &first_force, const series &first_robot, const series &other_force,
                             const series &other_robot) {
        return berth::find_copy({{first_force, command, {}}, {first_robot, command, {}}},
                                {{other_force, command, {}}, {other_robot, command, {}}})
            .has_value();
    };
    const series first_force = noisy(force, 1.0, random);
    const series robot = noisy(command, 5e-6, random);
    CHECK(is_copy(first_force, robot, noisy(first_force, 0.3, random), noisy(robot, 1.5e-6, random)));
    CHECK_FALSE(is_copy(first_force, robot, noisy(force, 1.0, random), noisy(command, 5e-6, random)));
    const series first_stairs = noisy(stairs, 5e-6, random);
    CHECK_FALSE(is_copy(first_force, first_stairs, noisy(force, 1.0, random), noisy(stairs, 5e-6, random)));
}
