/* Places of rows by their stamps, against how the stamps were made. */
#include <algorithm>
#include <doctest/doctest.h>
#include <random>
#include <string>

#include "../../sim_hal/diagnosis/record/row_stamps.h"

namespace
{

constexpr double period_s = 0.0025;

struct stamps {
    std::vector<double> time_s;
    std::vector<std::int64_t> places;
};

/* Rows at `places`, each late by what `late_s` tells of it. */
template <typename lateness>
stamps stamped(const std::vector<std::int64_t> &places, const lateness &late_s)
{
    stamps made{{}, places};
    for (std::size_t n = 0; n < places.size(); n++) {
        const double due_s = 7.0 + period_s * static_cast<double>(places[n]) + late_s(n);
        made.time_s.push_back(n == 0 ? due_s : std::max(due_s, made.time_s.back() + 1e-6));
    }
    return made;
}

std::vector<std::int64_t> without_rows(const std::vector<std::int64_t> &missing, std::int64_t count = 2000)
{
    std::vector<std::int64_t> places;
    for (std::int64_t place = 0; place < count; place++) {
        if (std::find(missing.begin(), missing.end(), place) == missing.end()) {
            places.push_back(place);
        }
    }
    return places;
}

} // namespace

TEST_CASE("row stamps: rows have the places that they were made at, however late or jittery their stamps")
{
    const auto on_time = [](std::size_t) { return 0.0; };
    const auto now_and_then = [](std::size_t n) { return n % 97 == 13 ? 0.9 * period_s : 0.0; };
    const auto by_three_rows = [](std::size_t n) { return n % 210 == 100 ? 3.2 * period_s : 0.0; };
    const auto rounded = [](std::size_t n) { return n % 2 == 0 ? 0.0 : 0.5e-3; };
    const struct {
        const char *name;
        stamps of;
    } cases[] = {
        {"on time", stamped(without_rows({}), on_time)},
        {"rows missing", stamped(without_rows({50, 400, 401, 1999}), on_time)},
        {"late now and then", stamped(without_rows({}), now_and_then)},
        {"late, the first one too", stamped(without_rows({}), [](std::size_t n) { return n == 0 ? 2e-3 : 0.0; })},
        {"late now and then, rows missing", stamped(without_rows({50, 400, 401}), now_and_then)},
        {"by more than three rows, which come in a burst", stamped(without_rows({}), by_three_rows)},
        {"rounded to ms", stamped(without_rows({700}), rounded)},
    };
    for (const auto &one : cases) {
        CAPTURE(std::string(one.name));
        const std::size_t rows = one.of.time_s.size();
        const std::vector<std::int64_t> found = berth::places_on_grid(one.of.time_s, {0, rows}, period_s);
        CHECK(found == one.of.places);
        const berth::row_clock clock = berth::clock_of(one.of.time_s, {{0, rows}}, period_s);
        CHECK(clock.line_s == doctest::Approx(period_s).epsilon(1e-5));
    }
}

TEST_CASE("row stamps: jitter of four tenths of a row makes no row missing")
{
    for (const unsigned seed : {1u, 2u, 3u, 4u, 5u}) {
        CAPTURE(seed);
        std::minstd_rand random(seed);
        std::uniform_real_distribution<double> jitter(-0.4 * period_s, 0.4 * period_s);
        const stamps made = stamped(without_rows({}), [&](std::size_t) { return jitter(random); });
        CHECK(berth::places_on_grid(made.time_s, {0, made.time_s.size()}, period_s) == made.places);
    }
}

TEST_CASE("row stamps: a logger whose delays add up has the period of its usual steps")
{
    std::vector<double> time_s{0.0};
    while (time_s.size() < 3000) {
        const std::size_t n = time_s.size();
        time_s.push_back(time_s.back() + (n % 150 == 0 ? 0.015 : n % 7 == 0 ? 0.011 : 0.01));
    }
    const berth::row_clock clock = berth::clock_of(time_s, {{0, time_s.size()}}, 0.01);
    CHECK(clock.has_usual_step);
    CHECK(clock.line_s > 1.01 * clock.median_step_s);
    const berth::lateness late = berth::lateness_of(time_s, {0, time_s.size()},
                                                    berth::places_on_grid(time_s, {0, time_s.size()}, 0.01), 0.01);
    CHECK(late.largest_s < 0.01);
}
