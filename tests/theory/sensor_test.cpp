/* The simulated force sensor's electronics, sampled directly and read from its frames. */
#include <cmath>
#include <doctest/doctest.h>
#include <limits>
#include <memory>

#include "../../firmware/can/codec.h"
#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/hil/sensor.h"
#include "../support/closed_loop.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

struct received_sample {
    std::int64_t time_ns;
    double force_N;
    bool saturated;
    std::uint8_t counter;
};

class sampled_sensor
{
  public:
    explicit sampled_sensor(std::vector<std::string> overrides)
    {
        overrides.push_back("run.seed=" + std::to_string(test_seed()));
        const rig rig = load_rig("ess", overrides);
        sensor_ = std::make_unique<sensor>(rig);
        bus_ = std::make_unique<can_bus>(rig.bus, HAL_BUS_SENSOR, rig.run.seed);
    }

    void sample(double force_N) { sensor_->sample({force_N}, *bus_); }

    /* All that has been sent. */
    std::vector<received_sample> received()
    {
        std::vector<received_sample> samples;
        hal_frame frame;
        while (bus_->receive(std::numeric_limits<std::int64_t>::max(), frame)) {
            berth_can_force_t raw;
            REQUIRE(frame.id == BERTH_CAN_FORCE_FRAME_ID);
            REQUIRE(berth_can_force_unpack(&raw, frame.data, frame.length) >= 0);
            samples.push_back(
                {frame.time_ns, berth_can_force_force_n_decode(raw.force_n), raw.saturated != 0, raw.counter});
        }
        return samples;
    }

    sensor &get() { return *sensor_; }

  private:
    std::unique_ptr<sensor> sensor_;
    std::unique_ptr<can_bus> bus_;
};

constexpr double step_N = 1e-7; /* of the frame */

double sample_once(const std::vector<std::string> &overrides, double force_N)
{
    sampled_sensor sensor(overrides);
    sensor.sample(force_N);
    const auto samples = sensor.received();
    REQUIRE(samples.size() == 1);
    return samples[0].force_N;
}

} // namespace

TEST_CASE("sensor: a sample arrives one delay after it was taken, at its phase in the tick")
{
    for (const double phase_ms : {0.0, 0.4, 2.4}) {
        for (const double delay_ms : {0.2, 2.5, 11.3}) {
            sampled_sensor sensor({"sensor.sample_phase_ms=" + std::to_string(phase_ms),
                                   "sensor.delay_ms=" + std::to_string(delay_ms)});
            for (std::int64_t i = 0; i < 10; i++) {
                CHECK(sensor.get().next_sample_ns() == ns_from_ms(phase_ms) + i * 2500000);
                sensor.sample(1.0);
            }
            const auto samples = sensor.received();
            REQUIRE(samples.size() == 10);
            for (std::int64_t i = 0; i < 10; i++) {
                const received_sample &sample = samples[static_cast<std::size_t>(i)];
                CHECK(sample.time_ns == ns_from_ms(phase_ms) + i * 2500000 + ns_from_ms(delay_ms));
                CHECK(sample.counter == i);
            }
        }
    }
}

/* The force held during a tick is that of the newest sample that has arrived, one exactly at the tick included. */
TEST_CASE("sensor: a delay of exactly one tick counts for that tick, a nanosecond more for the next")
{
    const auto lag_ticks = [](const char *delay) {
        closed_loop loop("ess", {"run.duration_s=2", delay});
        std::vector<double> true_N;
        int lag = -1;
        while (loop.tick()) {
            true_N.push_back(loop.truth().measured_force_N);
            const std::size_t now = true_N.size() - 1;
            if (now > 400) {
                for (int back = 0; back < 5; back++) {
                    const double held_N = loop.app().recorder.tick.force_N;
                    if (std::abs(true_N[now - static_cast<std::size_t>(back)] - held_N) <= 0.51 * step_N) {
                        CHECK((lag < 0 || lag == back));
                        lag = back;
                    }
                }
            }
        }
        return lag;
    };
    CHECK(lag_ticks("sensor.delay_ms=2.5") == 1);
    CHECK(lag_ticks("sensor.delay_ms=2.500001") == 2);
    CHECK(lag_ticks("sensor.delay_ms=5.0") == 2);
    CHECK(lag_ticks("sensor.delay_ms=0.2") == 1); /* shorter than a tick: the next one */
}

TEST_CASE("sensor: bias is added, the frame's step is all that is lost")
{
    for (const double force_N : {-1234.567890123, -1e-6, 0.0, 3.14159265, 40000.0}) {
        CHECK(std::abs(sample_once({}, force_N) - force_N) <= 0.5001 * step_N);
        CHECK(std::abs(sample_once({"sensor.bias_N=-7.25"}, force_N) - (force_N - 7.25)) <= 0.5001 * step_N);
    }
}

TEST_CASE("sensor: its resolution rounds to nearest")
{
    const std::vector<std::string> coarse = {"sensor.resolution_N=0.5"};
    CHECK(sample_once(coarse, 0.2499) == doctest::Approx(0.0));
    CHECK(sample_once(coarse, 0.2501) == doctest::Approx(0.5));
    CHECK(sample_once(coarse, -0.2501) == doctest::Approx(-0.5));
    CHECK(sample_once(coarse, 1234.74) == doctest::Approx(1234.5));
}

TEST_CASE("sensor: at the end of its range it stays there and says so")
{
    sampled_sensor sensor({"sensor.saturation_N=100"});
    for (const double force_N : {99.999, 100.001, -99.999, -100.001, 1e9, -1e9, 0.0}) {
        sensor.sample(force_N);
    }
    const auto samples = sensor.received();
    const double expected_N[] = {99.999, 100.0, -99.999, -100.0, 100.0, -100.0, 0.0};
    const bool expected_flag[] = {false, true, false, true, true, true, false};
    for (std::size_t i = 0; i < samples.size(); i++) {
        CHECK(std::abs(samples[i].force_N - expected_N[i]) <= step_N);
        CHECK(samples[i].saturated == expected_flag[i]);
    }

    sampled_sensor wide({}); /* only the frame's range is left: no wrap beyond it */
    for (const double force_N : {60000.0, -60000.0, 1e300}) {
        wide.sample(force_N);
    }
    for (const received_sample &sample : wide.received()) {
        CHECK(sample.saturated);
        CHECK(std::abs(sample.force_N) == doctest::Approx(CAN_FORCE_MAX_N));
    }
}

TEST_CASE("sensor: noise is white with the mean and deviation asked for")
{
    REPRODUCIBLE();
    constexpr int count = 40000;
    sampled_sensor sensor({"sensor.noise_N=2.5"});
    for (int i = 0; i < count; i++) {
        sensor.sample(10.0);
    }
    const auto samples = sensor.received();
    REQUIRE(samples.size() == count);
    double sum = 0.0;
    double squares = 0.0;
    double products = 0.0; /* of neighbours */
    double last = 0.0;
    for (const received_sample &sample : samples) {
        const double noise = (sample.force_N - 10.0) / 2.5;
        sum += noise;
        squares += noise * noise;
        products += noise * last;
        last = noise;
    }
    /* Standard errors of mean, variance and neighbour correlation of a normal sample; bounds of five of them. */
    CHECK(std::abs(sum / count) < 5.0 / std::sqrt(count));
    CHECK(std::abs(squares / count - 1.0) < 5.0 * std::sqrt(2.0 / count));
    CHECK(std::abs(products / count) < 5.0 / std::sqrt(count));
}

TEST_CASE("sensor: lost samples leave gaps in the counter, stale ones repeat it")
{
    REPRODUCIBLE();
    constexpr int count = 40000;
    sampled_sensor lossy({"sensor.loss_probability=0.05"});
    sampled_sensor stale({"sensor.stale_probability=0.05"});
    for (int i = 0; i < count; i++) {
        lossy.sample(i);
        stale.sample(i);
    }
    const double bound = 5.0 * std::sqrt(0.05 * 0.95 / count);

    const auto arrived = lossy.received();
    CHECK(std::abs(static_cast<double>(arrived.size()) / count - 0.95) < bound);
    for (const received_sample &sample : arrived) {
        REQUIRE(sample.counter == static_cast<std::uint8_t>(std::lround(sample.force_N)));
    }

    const auto all = stale.received();
    REQUIRE(all.size() == count);
    int repeated = 0;
    for (std::size_t i = 1; i < all.size(); i++) {
        const bool is_repeated = all[i].counter == all[i - 1].counter;
        repeated += is_repeated;
        REQUIRE((all[i].force_N == all[i - 1].force_N) == is_repeated);
        if (!is_repeated) {
            REQUIRE(std::abs(all[i].force_N - static_cast<double>(i)) < step_N);
            REQUIRE(all[i].counter == static_cast<std::uint8_t>(all[i - 1].counter + 1));
        }
    }
    CHECK(std::abs(repeated / double(count) - 0.05) < bound);
}

TEST_CASE("sensor: with its plug pulled nothing arrives")
{
    sampled_sensor sensor({});
    sensor.sample(1.0);
    sensor.get().set_silent(true);
    sensor.sample(2.0);
    sensor.get().set_silent(false);
    sensor.sample(3.0);
    const auto samples = sensor.received();
    REQUIRE(samples.size() == 2);
    CHECK(samples[1].force_N == doctest::Approx(3.0));
    CHECK(samples[1].counter == samples[0].counter + 2);
}

} // namespace berth
