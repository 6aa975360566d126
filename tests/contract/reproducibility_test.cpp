/* Nothing is shared between loops and nothing depends on the machine's clock: a seed repeats a run bit for bit,
 * alone or among others. */
#include <cstring>
#include <doctest/doctest.h>
#include <memory>

#include "../../sim_hal/hil/random.h"
#include "../support/closed_loop.h"
#include "../support/files.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

const std::vector<std::string> noisy = {
    "run.duration_s=5",          "sensor.noise_N=0.5",         "sensor.loss_probability=0.01",
    "bus.loss_probability=0.01", "bus.error_probability=0.01", "robot.jitter_ms=0.3",
};

std::string log_of(const std::vector<std::string> &overrides)
{
    const temporary_folder folder;
    const rig rig = load_rig("ess", overrides);
    {
        closed_loop loop(rig, folder / "log.ulg");
        while (loop.tick()) {
        }
    }
    return read_bytes(folder / "log.ulg");
}

/* FNV-1a over everything that one tick leaves: the firmware's record and what was really so. */
class fingerprint
{
  public:
    void add(const closed_loop &loop)
    {
        const rig_truth truth = loop.truth();
        add(&loop.app().recorder.tick, sizeof(tick_record));
        add(&truth, sizeof truth);
    }
    std::uint64_t value() const { return hash_; }

  private:
    void add(const void *data, std::size_t size_bytes)
    {
        const auto *bytes = static_cast<const unsigned char *>(data);
        for (std::size_t i = 0; i < size_bytes; i++) {
            hash_ = (hash_ ^ bytes[i]) * 0x100000001b3u;
        }
    }

    std::uint64_t hash_ = 0xcbf29ce484222325u;
};

/* Rigs that differ in everything that comes to mind. */
rig random_rig(std::int64_t seed, std::uint32_t number)
{
    random_stream random(seed, 100 + number);
    const auto among = [&](std::initializer_list<const char *> choices) {
        return std::string(
            choices
                .begin()[static_cast<std::size_t>(random.uniform() * 0.999 * static_cast<double>(choices.size()))]);
    };
    const auto between = [&](double low, double high) {
        return std::to_string(low + (high - low) * random.uniform());
    };
    const std::string shipped = among({"ess", "ess-50hz", "ess-half-dead-time", "concept-foam", "concept-copper"});
    return load_rig(shipped, {
                                 "run.duration_s=2",
                                 "run.seed=" + std::to_string(number),
                                 "robot.dead_time_ms=" + between(20.0, 50.0),
                                 "robot.interpolation=" + among({"linear", "hold"}),
                                 "robot.transfer_frequency_Hz=" + among({"inf", "6", "12"}),
                                 "robot.clock=" + among({"locked", "free"}),
                                 "robot.clock_drift_ppm=" + between(-1000.0, 1000.0),
                                 "robot.jitter_ms=" + among({"0", "0.2", "1.0"}),
                                 "sensor.low_pass_order=" + among({"1", "2"}),
                                 "sensor.noise_N=" + among({"0", "0.1", "2"}),
                                 "sensor.loss_probability=" + among({"0", "0.01"}),
                                 "bus.loss_probability=" + among({"0", "0.005"}),
                                 "manipulator.integrator=" + among({"exact", "semi_implicit_euler", "rk4"}),
                                 "solver.kind=" + among({"fast", "fast", "fast", "cvode"}),
                             });
}

} // namespace

TEST_CASE("the same seed gives the same log, byte for byte; another seed another one")
{
    const std::string first = log_of(noisy);
    CHECK(first.size() > 100000);
    CHECK(first == log_of(noisy));

    std::vector<std::string> other = noisy;
    other.push_back("run.seed=2");
    const std::string second = log_of(other);
    CHECK(first != second);
}

TEST_CASE("without anything random the seed changes nothing but its own line in the log")
{
    const auto fingerprint_of = [](const char *seed) {
        closed_loop loop("ess", {"run.duration_s=5", seed});
        fingerprint print;
        while (loop.tick()) {
            print.add(loop);
        }
        return print.value();
    };
    CHECK(fingerprint_of("run.seed=1") == fingerprint_of("run.seed=2"));
}

TEST_CASE("CVODE repeats itself bit for bit as well")
{
    std::vector<std::string> overrides = noisy;
    overrides.push_back("solver.kind=cvode");
    CHECK(log_of(overrides) == log_of(overrides));
}

TEST_CASE("64 different loops tick by tick in one process are the same 64 loops one after another")
{
    REPRODUCIBLE();
    constexpr std::uint32_t count = 64;
    std::vector<rig> rigs;
    std::vector<std::uint64_t> alone;
    for (std::uint32_t i = 0; i < count; i++) {
        rigs.push_back(random_rig(test_seed(), i));
        closed_loop loop(rigs.back());
        fingerprint print;
        while (loop.tick()) {
            print.add(loop);
        }
        alone.push_back(print.value());
    }

    std::vector<std::unique_ptr<closed_loop>> loops;
    loops.reserve(count);
    for (const rig &rig : rigs) {
        loops.push_back(std::make_unique<closed_loop>(rig));
    }
    std::vector<fingerprint> together(count);
    for (bool is_any_running = true; is_any_running;) {
        is_any_running = false;
        for (std::uint32_t i = 0; i < count; i++) {
            if (loops[i]->tick()) {
                together[i].add(*loops[i]);
                is_any_running = true;
            }
        }
    }
    for (std::uint32_t i = 0; i < count; i++) {
        CAPTURE(i);
        CHECK(together[i].value() == alone[i]);
        CHECK((i == 0 || alone[i] != alone[i - 1])); /* the rigs do differ */
    }
}

} // namespace berth
