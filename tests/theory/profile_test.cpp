/* Operator profiles: each is what its name says, and the rate is the derivative of the value. */
#include <cmath>
#include <doctest/doctest.h>
#include <fstream>

#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/hil/profile.h"
#include "../support/files.h"

namespace berth
{

namespace
{

profile make_profile(std::vector<std::string> overrides)
{
    for (const char *fixed :
         {"profile.offset_m=0.1", "profile.amplitude_m=0.02", "profile.start_s=0.5", "profile.duration_s=2"}) {
        overrides.insert(overrides.begin(), fixed);
    }
    return profile(load_rig("ess", overrides));
}

/* Central differences, two widths extrapolated: error h^4. */
double slope(const profile &p, double time_s)
{
    const auto difference = [&](double h) { return (p.at(time_s + h).value - p.at(time_s - h).value) / (2.0 * h); };
    constexpr double h = 1e-4;
    return (4.0 * difference(h) - difference(2.0 * h)) / 3.0;
}

/* Where the profile is smooth: away from start, end and the corners of a file. */
void check_rate(const profile &p, double from_s, double to_s, double tolerance)
{
    constexpr int points = 200;
    for (int i = 1; i < points; i++) {
        const double t = from_s + (to_s - from_s) * i / points;
        CAPTURE(t);
        CHECK(std::abs(p.at(t).rate - slope(p, t)) < tolerance);
    }
}

} // namespace

TEST_CASE("profile: before its start it rests at the offset")
{
    for (const std::string kind :
         {"rest", "step", "ramp", "minimum_jerk", "chirp", "multisine", "triangle", "pulses"}) {
        const profile p = make_profile({"profile.kind=" + kind});
        for (const double t : {-1.0, 0.0, 0.4999}) {
            CHECK(p.at(t).value == doctest::Approx(0.1));
            CHECK(p.at(t).rate == 0.0);
        }
        CHECK(p.at(0.5).value == doctest::Approx(kind == "step" ? 0.12 : 0.1));
    }
}

TEST_CASE("profile: step and ramp")
{
    const profile step = make_profile({"profile.kind=step"});
    CHECK(step.at(0.5).value == doctest::Approx(0.12));
    CHECK(step.at(9.0).value == doctest::Approx(0.12));
    CHECK(step.at(9.0).rate == 0.0);

    const profile ramp = make_profile({"profile.kind=ramp"});
    CHECK(ramp.at(1.5).value == doctest::Approx(0.11));
    CHECK(ramp.at(1.5).rate == doctest::Approx(0.01));
    CHECK(ramp.at(2.5).value == doctest::Approx(0.12));
    CHECK(ramp.at(2.5).rate == 0.0);
    check_rate(ramp, 0.5, 2.5, 1e-10);
}

TEST_CASE("profile: the minimum-jerk move starts and ends at rest, without acceleration, and is symmetric")
{
    const profile move = make_profile({"profile.kind=minimum_jerk"});
    const auto acceleration = [&](double t, double h) { return (move.at(t + h).rate - move.at(t).rate) / h; };
    CHECK(move.at(0.5).value == doctest::Approx(0.1));
    CHECK(move.at(2.5).value == doctest::Approx(0.12));
    CHECK(move.at(0.5).rate == 0.0);
    CHECK(move.at(2.5).rate == 0.0);
    CHECK(std::abs(acceleration(0.5, 1e-6)) < 1e-6); /* grows from 0 with 60 A / T^3 */
    CHECK(std::abs(acceleration(2.5, -1e-6)) < 1e-6);
    CHECK(move.at(1.5).value == doctest::Approx(0.11));
    CHECK(move.at(1.5).rate == doctest::Approx(15.0 / 8.0 * 0.02 / 2.0)); /* the well-known peak velocity */
    for (int i = 0; i < 100; i++) {
        const double s = 0.01 * i;
        CHECK(move.at(1.5 + s).value + move.at(1.5 - s).value == doctest::Approx(0.22));
        CHECK(move.at(1.5 + s).rate == doctest::Approx(move.at(1.5 - s).rate));
    }
    check_rate(move, 0.5, 2.5, 1e-9);
    CHECK(move.at(9.0).value == doctest::Approx(0.12));
}

TEST_CASE("profile: the chirp sweeps its band and rests afterwards")
{
    const profile chirp =
        make_profile({"profile.kind=chirp", "profile.frequency_start_Hz=0.5", "profile.frequency_end_Hz=4"});
    check_rate(chirp, 0.5, 2.5, 1e-7);
    /* Frequency from the phase: rate^2 + (w value)^2 = (w A)^2 at the frequency of that instant. */
    for (const double s : {0.2, 0.9, 1.7}) {
        const double w = 2.0 * M_PI * (0.5 + 3.5 * s / 2.0);
        const profile_point point = chirp.at(0.5 + s);
        CHECK(std::hypot(point.rate, w * (point.value - 0.1)) == doctest::Approx(w * 0.02));
    }
    CHECK(chirp.at(2.5).value == doctest::Approx(0.1));
    CHECK(chirp.at(2.5).rate == 0.0);
}

TEST_CASE("profile: the multisine starts without a step, repeats, and depends on the seed")
{
    const std::vector<std::string> overrides = {"profile.kind=multisine", "profile.frequency_start_Hz=0.5",
                                                "profile.frequency_end_Hz=5"};
    const profile sines = make_profile(overrides);
    check_rate(sines, 0.5, 4.5, 1e-7);
    CHECK(sines.at(0.5).value == doctest::Approx(0.1));
    double largest = 0.0;
    for (int i = 0; i < 150; i++) {
        const double t = 0.5 + 0.013 * i;
        CHECK(sines.at(t).value == doctest::Approx(sines.at(t + 2.0).value));
        largest = std::max(largest, std::abs(sines.at(t).value - sines.at(0.5).value));
    }
    CHECK(largest > 0.005);

    std::vector<std::string> other = overrides;
    other.push_back("run.seed=2");
    CHECK(std::abs(make_profile(other).at(1.0).value - sines.at(1.0).value) > 1e-6);
    CHECK(make_profile(overrides).at(1.0).value == sines.at(1.0).value);
}

TEST_CASE("profile: the triangle goes at one speed to both sides, and repeats")
{
    const profile triangle = make_profile({"profile.kind=triangle"});
    for (const auto &[t, value] : {std::pair{1.0, 0.12}, {1.5, 0.1}, {2.0, 0.08}, {2.5, 0.1}, {3.0, 0.12}}) {
        CHECK(triangle.at(t).value == doctest::Approx(value));
    }
    for (const double t : {0.7, 1.3, 1.9, 2.2, 2.9, 3.4}) {
        CHECK(std::abs(triangle.at(t).rate) == doctest::Approx(4.0 * 0.02 / 2.0));
        CHECK(std::abs(triangle.at(t).rate - slope(triangle, t)) < 1e-9);
    }
}

TEST_CASE("profile: pulses are half sines with rest between them")
{
    const profile pulses = make_profile({"profile.kind=pulses", "profile.frequency_end_Hz=2"});
    check_rate(pulses, 0.5, 0.75, 1e-7);
    for (const double period : {0.0, 2.0, 4.0}) {
        CHECK(pulses.at(0.625 + period).value == doctest::Approx(0.12));
        CHECK(pulses.at(1.1 + period).value == doctest::Approx(0.1));
        CHECK(pulses.at(1.1 + period).rate == 0.0);
    }
}

TEST_CASE("profile: a file is followed on straight lines and held at its ends")
{
    const temporary_folder folder;
    std::ofstream(folder / "move.csv") << "t_s,other,position\n10.0,5,1\n10.5,6,2\n11.5,7,1.5\n";
    const profile file = make_profile({"profile.kind=file", "profile.file=" + (folder / "move.csv"),
                                       "profile.column=position", "profile.scale=0.01"});
    CHECK(file.at(0.0).value == doctest::Approx(0.11)); /* offset and scale times the first value */
    CHECK(file.at(0.0).rate == 0.0);
    CHECK(file.at(0.5).value == doctest::Approx(0.11));
    CHECK(file.at(0.75).value == doctest::Approx(0.115));
    CHECK(file.at(0.75).rate == doctest::Approx(0.02));
    CHECK(file.at(1.5).value == doctest::Approx(0.1175));
    CHECK(file.at(1.5).rate == doctest::Approx(-0.005));
    CHECK(file.at(2.0).value == doctest::Approx(0.115));
    CHECK(file.at(100.0).value == doctest::Approx(0.115));
    CHECK(file.at(100.0).rate == 0.0);
    check_rate(file, 0.5, 1.0, 1e-9);
    check_rate(file, 1.0, 2.0, 1e-9);
}

TEST_CASE("profile: the force interface takes its amplitude in N and no offset")
{
    const profile step = make_profile({"profile.kind=step", "operator.interface=force", "profile.amplitude_N=12"});
    CHECK(step.at(0.0).value == 0.0);
    CHECK(step.at(1.0).value == doctest::Approx(12.0));
}

} // namespace berth
