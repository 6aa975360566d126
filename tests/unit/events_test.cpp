#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <vector>

#include "../../firmware/pi.h"
#include "hal/rig/rig_file.h"
#include "seeded.h"
#include "sim_hal/diagnosis/noise/lattice_step.h"
#include "sim_hal/diagnosis/replay/block_model.h"
#include "sim_hal/diagnosis/samples/events.h"
#include "sim_hal/diagnosis/samples/spikes.h"

namespace
{

constexpr double period_s = 0.0025;
constexpr std::size_t lattice_rows = 12000;

/* A channel as it comes: a slow swing with noise, in steps. */
struct channel {
    double amplitude;
    double noise;
    double step;

    double at(seeded::engine &random, std::size_t n) const
    {
        const double radius = std::sqrt(-2.0 * std::log(seeded::uniform(random, 1e-300, 1.0)));
        const double normal = radius * std::cos(berth::two_pi * seeded::uniform(random, 0.0, 1.0));
        const double time_s = period_s * static_cast<double>(n);
        const double clean =
            amplitude * (std::sin(berth::two_pi * 0.7 * time_s) + 0.4 * std::sin(berth::two_pi * 1.9 * time_s));
        return step * std::round((clean + noise * normal) / step);
    }
};

berth::record empty_record(std::size_t rows)
{
    berth::record made;
    made.period_s = period_s;
    made.segments = {{0, rows}};
    for (std::size_t n = 0; n < rows; n++) {
        made.time_s.push_back(period_s * static_cast<double>(n));
    }
    return made;
}

const berth::event_finding *find(const std::vector<berth::event_finding> &found, const std::string &name)
{
    const auto one = std::find_if(found.begin(), found.end(), [&](const auto &f) { return f.effect->name == name; });
    return one == found.end() ? nullptr : &*one;
}

} // namespace

TEST_CASE("events: the share of forces that were lost is told without bias, and how well it is known")
{
    SEEDED(random, "events: the share of forces*");
    constexpr int records = 20;
    const channel force{10.0, 0.02, 0.004};
    for (const double lost : {0.01, 0.05, 0.17}) {
        CAPTURE(lost);
        double off = 0.0; /* standard deviations, summed up */
        for (int i = 0; i < records; i++) {
            berth::record record = empty_record(12000);
            for (std::size_t n = 0; n < record.size(); n++) {
                const bool is_lost = n > 0 && seeded::uniform(random, 0.0, 1.0) < lost;
                record.force_N.push_back(is_lost ? record.force_N.back() : force.at(random, n));
            }
            berth::sample_events events;
            const auto found = berth::find_repeats(record, berth::rig{}, events);
            const berth::event_finding *const told = find(found, "sensor.dropouts");
            REQUIRE(told != nullptr);
            off += (told->values[0] - lost) / (told->ci95[0] / 1.96);
            CHECK(std::abs(told->values[0] - lost) < 2.5 * told->ci95[0]);
        }
        CHECK(std::abs(off) < 3.5 * std::sqrt(static_cast<double>(records)));
    }
}

TEST_CASE(
    "events: a force that stands on coarse steps most of the time makes no lost ticks of a robot's repetitions")
{
    SEEDED(random, "events: a force that stands on coarse steps*");
    const channel robot{2e-3, 7e-6, 5.1e-6};
    const channel force{20.0, 0.23, 6.2};
    for (int i = 0; i < 60; i++) {
        berth::record record = empty_record(13000);
        for (std::size_t n = 0; n < record.size(); n++) {
            record.robot_position_m.push_back(robot.at(random, n));
            record.force_N.push_back(force.at(random, n));
        }
        berth::sample_events events;
        CHECK(find(berth::find_repeats(record, berth::rig{}, events), "loop.lost_samples") == nullptr);
    }
}

TEST_CASE("events: a few ticks lost as a whole show by both channels, where a coarse force alone hides them")
{
    SEEDED(random, "events: a few ticks lost*");
    const channel robot{1e-3, 2e-6, 1e-6};
    const channel force{3.0, 0.1, 0.08}; /* repeats every fourth sample by chance */
    for (const double lost : {0.0, 0.004}) {
        CAPTURE(lost);
        for (int i = 0; i < 20; i++) {
            berth::record record = empty_record(11000);
            std::size_t count = 0;
            for (std::size_t n = 0; n < record.size(); n++) {
                const bool is_lost = n > 0 && seeded::uniform(random, 0.0, 1.0) < lost;
                count += is_lost;
                record.robot_position_m.push_back(is_lost ? record.robot_position_m.back() : robot.at(random, n));
                record.force_N.push_back(is_lost ? record.force_N.back() : force.at(random, n));
            }
            berth::sample_events events;
            const auto found = berth::find_repeats(record, berth::rig{}, events);
            const berth::event_finding *const told = find(found, "loop.lost_samples");
            CHECK((told != nullptr) == (lost > 0.0));
            CHECK(find(found, "sensor.dropouts") == nullptr);
            if (told != nullptr) {
                CHECK(static_cast<double>(told->count) > 0.3 * static_cast<double>(count));
                CHECK(static_cast<double>(told->count) < 1.3 * static_cast<double>(count) + 3.0);
            }
        }
    }
}

TEST_CASE("events: a single force off the steps of all others makes no losses of what they repeat by chance")
{
    SEEDED(random, "events: a single force off*");
    const channel force{10.0, 0.1, 0.5};
    for (const std::size_t off : {std::size_t{0}, std::size_t{5000}, lattice_rows}) {
        CAPTURE(off);
        berth::record data = empty_record(lattice_rows);
        for (std::size_t n = 0; n < lattice_rows; n++) {
            data.force_N.push_back(force.at(random, n) + (n == off ? 0.0361 : 0.0));
        }
        CHECK(berth::lattice_step(data.force_N) == doctest::Approx(0.5).epsilon(1e-12));
        berth::sample_events events;
        CHECK(berth::find_repeats(data, berth::rig{}, events).empty());
        const auto found = berth::find_quantisation(data, berth::rig{}, 0.15);
        REQUIRE(found.size() == 1);
        CHECK(found[0].values[0] == doctest::Approx(0.5).epsilon(1e-12));
    }
}

TEST_CASE("events: coarse steps are found beneath noise, and beside values that are off them")
{
    SEEDED(random, "events: coarse steps are found*");
    const channel force{10.0, 0.05, 0.5};
    struct spoiled {
        double noise;
        double astray;
    };
    for (const spoiled by : {spoiled{0.0, 0.03}, spoiled{0.02, 0.0}, spoiled{0.04, 0.0}, spoiled{0.02, 0.02}}) {
        CAPTURE(by.noise);
        CAPTURE(by.astray);
        std::vector<double> force_N(lattice_rows);
        for (std::size_t n = 0; n < lattice_rows; n++) {
            const bool is_astray = seeded::uniform(random, 0.0, 1.0) < by.astray;
            force_N[n] = force.at(random, n) + by.noise * std::sqrt(3.0) * seeded::uniform(random, -1.0, 1.0) +
                         (is_astray ? seeded::uniform(random, -0.2, 0.2) : 0.0);
        }
        CHECK(berth::lattice_step(force_N) == doctest::Approx(0.5).epsilon(2e-3));
    }
}

TEST_CASE("events: what rests, jumps or is held by a limit is on no steps for that")
{
    SEEDED(random, "events: what rests, jumps or is held*");
    for (int i = 0; i < 40; i++) {
        std::vector<double> spikes(lattice_rows);
        std::vector<double> jumps(lattice_rows);
        std::vector<double> limited(lattice_rows);
        double level = 0.0;
        for (std::size_t n = 0; n < lattice_rows; n++) {
            const double noise = seeded::uniform(random, -0.05, 0.05);
            level = seeded::uniform(random, 0.0, 1.0) < 0.1 ? seeded::uniform(random, -3.0, 3.0) : level;
            jumps[n] = level + noise;
            limited[n] = std::clamp(3.0 * std::sin(1e-2 * static_cast<double>(n)), -1.0, 1.0) + 1e-2 * noise;
            spikes[n] = std::sin(1e-3 * static_cast<double>(n * (i + 1))) + noise +
                        (seeded::uniform(random, 0.0, 1.0) < 0.08 ? 2.0 : 0.0);
        }
        CHECK(berth::lattice_step(spikes) == 0.0);
        CHECK(berth::lattice_step(jumps) == 0.0);
        CHECK(berth::lattice_step(limited) == 0.0);
    }
}

TEST_CASE("events: forces that lie anywhere lie on no steps")
{
    SEEDED(random, "events: forces that lie anywhere*");
    std::vector<double> force_N(lattice_rows);
    std::generate(force_N.begin(), force_N.end(), [&] { return seeded::uniform(random, -1.0, 1.0); });
    CHECK(berth::lattice_step(force_N) == 0.0);
}

TEST_CASE("events: beside a robot that switches, samples thrown off are spikes only if they are of one size")
{
    SEEDED(random, "events: beside a robot*");
    constexpr std::size_t rows = 4000;
    constexpr std::size_t every = 97;
    const berth::sample_events none{};
    const berth::rig rig = berth::load_rig("ess", {});
    for (const bool are_alike : {true, false}) {
        CAPTURE(are_alike);
        berth::record data = empty_record(rows);
        const channel noise{0.0, 0.05, 1e-6};
        std::vector<double> error(rows);
        std::size_t count = 0;
        for (std::size_t n = 0; n < rows; n++) {
            error[n] = noise.at(random, n);
            if (n % every == 50) {
                error[n] += (n % 2 == 0 ? 1.0 : -1.0) * (are_alike ? 3.0 : seeded::uniform(random, 0.6, 6.0));
                count++;
            }
        }
        data.force_N = error;
        data.command_position_m.assign(rows, 0.0);
        const berth::block_model model(berth::block::force, data, rig, none, berth::held_out_parts::none);
        berth::sample_events events;
        const auto all = berth::find_spikes(model, error, events);
        CHECK(all.size() == 1);
        CHECK(all.front().count + 2 >= count); /* but those before the record has settled */
        events = {};
        const auto wanted = berth::find_spikes(model, error, events, berth::spikes_wanted::of_one_size);
        CHECK(wanted.size() == (are_alike ? 1 : 0));
        CHECK(berth::count_of(events.spike) == (are_alike ? wanted.front().count : 0));
    }
}

namespace
{

std::size_t count_of_spikes(const std::vector<double> &force_N, const std::vector<double> &error_N)
{
    const berth::sample_events none{};
    const berth::rig rig = berth::load_rig("ess", {});
    berth::record data = empty_record(force_N.size());
    data.force_N = force_N;
    data.command_position_m.assign(force_N.size(), 0.0);
    const berth::block_model model(berth::block::force, data, rig, none, berth::held_out_parts::none);
    berth::sample_events events;
    const auto found = berth::find_spikes(model, error_N, events);
    return found.empty() ? 0 : found.front().count;
}

/* How many spikes are found in noise of `noise_N` with samples thrown off by 3 N, where `is_thrown` says so. The
 * sensor stands still where `is_held` does. */
template <typename Thrown, typename Held>
std::size_t spikes_in(seeded::engine &random, double noise_N, Thrown is_thrown, Held is_held)
{
    constexpr std::size_t rows = 8000;
    const channel noise{0.0, noise_N, 1e-6};
    std::vector<double> error_N(rows);
    for (std::size_t n = 0; n < rows; n++) {
        error_N[n] = is_held(n) ? 0.0 : noise.at(random, n) + (is_thrown(n) ? (n % 2 == 0 ? 3.0 : -3.0) : 0.0);
    }
    return count_of_spikes(error_N, error_N);
}

} // namespace

TEST_CASE("events: noise that is louder now and then is no spike")
{
    SEEDED(random, "events: noise that is*");
    constexpr std::size_t rows = 8000;
    const channel quiet{0.0, 0.05, 1e-6};
    const channel loud{0.0, 1.0, 1e-6};
    std::vector<double> error_N(rows);
    for (std::size_t n = 0; n < rows; n++) {
        error_N[n] = (n % 2000 < 1000 ? loud : quiet).at(random, n);
    }
    CHECK(count_of_spikes(error_N, error_N) == 0);
    for (std::size_t n = 100; n < rows; n += 200) {
        error_N[n] += 20.0;
    }
    CHECK(count_of_spikes(error_N, error_N) >= 35);
}

TEST_CASE("events: noise with long tails, or that is loud for a few rows, is no spike")
{
    SEEDED(random, "events: noise with long tails*");
    constexpr std::size_t rows = 12000;
    const channel normal{0.0, 0.2, 1e-9};
    std::vector<double> tailed_N(rows); /* Student's t with 3 degrees of freedom */
    std::vector<double> bursts_N(rows);
    std::vector<double> thrown_N(rows);
    for (std::size_t n = 0; n < rows; n++) {
        double square = 0.0;
        for (int i = 0; i < 3; i++) {
            square += std::pow(normal.at(random, n) / 0.2, 2) / 3.0;
        }
        tailed_N[n] = normal.at(random, n) / std::sqrt(square);
        bursts_N[n] = normal.at(random, n) * (n % 500 < 8 ? 6.0 : 1.0);
        const bool is_thrown = n % 80 == 40;
        thrown_N[n] = normal.at(random, n) + (is_thrown ? 4.0 * normal.at(random, n) / 0.2 : 0.0);
    }
    CHECK(count_of_spikes(tailed_N, tailed_N) == 0);
    CHECK(count_of_spikes(bursts_N, bursts_N) == 0);
    CHECK(count_of_spikes(thrown_N, thrown_N) >= 70); /* of 150 of normal size, 4 N rms */
}

TEST_CASE("events: spikes hardly larger than what is surely one are counted, too")
{
    SEEDED(random, "events: spikes hardly larger*");
    constexpr std::size_t rows = 12000;
    const channel noise{0.0, 0.2, 1e-9};
    std::vector<double> error_N(rows);
    for (std::size_t n = 0; n < rows; n++) {
        error_N[n] =
            noise.at(random, n) + (n % 300 == 150 ? 2.1 : 0.0); /* 40, 8.5 times the noise of a difference */
    }
    CHECK(count_of_spikes(error_N, error_N) >= 30);
}

TEST_CASE("events: a sample that was held where the force turns is no spike")
{
    SEEDED(random, "events: a sample that was*");
    constexpr std::size_t rows = 8000;
    const channel noise{0.0, 0.05, 1e-6};
    std::vector<double> force_N(rows);
    std::vector<double> error_N(rows);
    for (const bool is_held : {true, false}) {
        for (std::size_t n = 0; n < rows; n++) {
            const double true_N = 30.0 * std::cos(0.25 * std::acos(-1.0) * static_cast<double>(n));
            force_N[n] = true_N + noise.at(random, n);
            if (n % 200 == 80) { /* at the top, where the neighbours are 8.8 N lower */
                force_N[n] = is_held ? force_N[n - 1] : true_N - 9.0;
            }
            error_N[n] = force_N[n] - true_N;
        }
        const std::size_t found = count_of_spikes(force_N, error_N);
        CHECK((is_held ? found == 0 : found >= 35));
    }
}

TEST_CASE("events: what comes in a few bursts is no spike")
{
    SEEDED(random, "events: what comes in*");
    const auto never = [](std::size_t) { return false; };
    const auto scattered = [](std::size_t n) { return n % 199 == 100; };
    const auto in_bursts = [](std::size_t n) { return n % 2000 > 1000 && n % 2000 < 1031 && n % 3 == 0; };
    CHECK(spikes_in(random, 0.05, scattered, never) >= 39);
    CHECK(spikes_in(random, 0.05, in_bursts, never) == 0);
}

TEST_CASE("events: spikes right after each other are two, once others are known")
{
    SEEDED(random, "events: spikes right after*");
    const auto never = [](std::size_t) { return false; };
    const auto alone = [](std::size_t n) { return n % 397 == 100; };
    const auto in_pairs = [&](std::size_t n) { return alone(n) || n % 1993 == 560 || n % 1993 == 561; };
    const auto in_fours = [&](std::size_t n) { return alone(n) || (n % 1993 >= 560 && n % 1993 < 564); };
    const std::size_t single = spikes_in(random, 0.05, alone, never);
    CHECK(single >= 19);
    CHECK(spikes_in(random, 0.05, in_pairs, never) == single + 8);
    CHECK(spikes_in(random, 0.05, in_fours, never) == single);
}

TEST_CASE("events: noise is no spike where a sensor stands still most of the time")
{
    SEEDED(random, "events: noise is no*");
    const auto never = [](std::size_t) { return false; };
    const auto thrown = [](std::size_t n) { return n % 400 == 350; };
    const auto held = [](std::size_t n) { return n % 400 < 300; };
    CHECK(spikes_in(random, 0.05, never, held) == 0);
    CHECK(spikes_in(random, 0.05, thrown, held) >= 19);
}
