/* The simulated CAN bus: bit times, queueing, loss, bursts, errors. */
#include <cmath>
#include <doctest/doctest.h>

#include "../../sim_hal/hil/can_bus.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

hal_frame numbered_frame(std::uint8_t number)
{
    return {0, 0x40, HAL_BUS_SENSOR, 8, 0, 0, {number, 0, 0, 0, 0, 0, 0, 0}};
}

can_bus make_bus(const bus_rig &rig, std::int64_t seed = 1)
{
    return {rig, HAL_BUS_SENSOR, seed};
}

/* Five standard deviations of a rate measured over `count` draws. */
double rate_bound(double probability, double count)
{
    return 5.0 * std::sqrt(probability * (1.0 - probability) / count);
}

constexpr std::int64_t frame_ns = 135000;

} // namespace

/* 34 + 8 n bits from start of frame to the CRC, at worst one stuffed after the first 5 and every 4 more; 13 bits of
 * delimiters, acknowledge, end of frame and interframe space. */
TEST_CASE("bus: a frame takes the bits of its length at worst-case stuffing")
{
    const int bits[] = {55, 65, 75, 85, 95, 105, 115, 125, 135};
    for (int bytes = 0; bytes <= 8; bytes++) {
        CHECK(frame_time_ns({}, bytes) == 1000 * bits[bytes]);
        CHECK(make_bus({}).frame_time_ns(bytes) == 1000 * bits[bytes]);
        bus_rig slow;
        slow.bit_rate_bit_per_s = 125e3;
        CHECK(frame_time_ns(slow, bytes) == 8000 * bits[bytes]);
        bus_rig ideal;
        ideal.ideal = true;
        CHECK(frame_time_ns(ideal, bytes) == 0);
    }
}

TEST_CASE("bus: frames that are ready together follow one another, back to back")
{
    can_bus bus = make_bus({});
    for (std::uint8_t i = 0; i < 100; i++) {
        std::int64_t end_ns = 0;
        CHECK(bus.transmit(numbered_frame(i), 5000, &end_ns));
        CHECK(end_ns == 5000 + (i + 1) * frame_ns);
    }
    std::int64_t end_ns = 0;
    bus.transmit(numbered_frame(0), 1000000000, &end_ns); /* the bus has long been idle */
    CHECK(end_ns == 1000000000 + frame_ns);
}

TEST_CASE("bus: frames to the loop arrive in order, not before their end of frame")
{
    can_bus bus = make_bus({});
    for (std::uint8_t i = 0; i < 200; i++) {
        bus.transmit_to_loop(numbered_frame(i), 1000 * i);
    }
    hal_frame frame;
    for (std::uint8_t i = 0; i < 200; i++) {
        const std::int64_t arrival_ns = (i + 1) * frame_ns;
        CHECK_FALSE(bus.receive(arrival_ns - 1, frame));
        REQUIRE(bus.receive(arrival_ns, frame)); /* exactly at its arrival it counts */
        CHECK(frame.time_ns == arrival_ns);
        CHECK(frame.data[0] == i);
    }
    CHECK_FALSE(bus.receive(1000000000, frame));
}

TEST_CASE("bus: single losses come at their rate and independently")
{
    REPRODUCIBLE();
    bus_rig rig;
    rig.loss_probability = 0.1;
    can_bus bus = make_bus(rig, test_seed());
    constexpr int count = 100000;
    int lost = 0;
    int lost_twice = 0; /* in a row */
    bool was_lost = false;
    for (int i = 0; i < count; i++) {
        std::int64_t end_ns = 0;
        const bool is_lost = !bus.transmit(numbered_frame(0), i * frame_ns, &end_ns);
        lost += is_lost;
        lost_twice += is_lost && was_lost;
        was_lost = is_lost;
    }
    CHECK(std::abs(lost / double(count) - 0.1) < rate_bound(0.1, count));
    CHECK(std::abs(lost_twice / double(count) - 0.01) < rate_bound(0.01, count));
}

/* Lengths are geometric with the mean given; between bursts a burst starts with probability p. */
TEST_CASE("bus: bursts start at their rate and have their mean length")
{
    REPRODUCIBLE();
    bus_rig rig;
    rig.burst_probability = 0.01;
    rig.burst_length_frames = 8.0;
    can_bus bus = make_bus(rig, test_seed());
    constexpr int count = 400000;
    int lost = 0;
    int runs = 0;
    bool was_lost = false;
    for (int i = 0; i < count; i++) {
        std::int64_t end_ns = 0;
        const bool is_lost = !bus.transmit(numbered_frame(0), i * frame_ns, &end_ns);
        lost += is_lost;
        runs += is_lost && !was_lost;
        was_lost = is_lost;
    }
    /* A burst and the good frames before it: 8 + 0.99 / 0.01 frames. */
    const double share = 8.0 / (8.0 + 0.99 / 0.01);
    const double bursts = count * share / 8.0;
    /* Bursts are geometric: standard deviation about their mean; two that touch look like one run, one in 100. */
    CHECK(std::abs(lost / double(count) - share) < 5.0 * share * std::sqrt(2.0 / bursts));
    CHECK(std::abs(lost / double(runs) - 8.0 / 0.99) < 5.0 * 8.0 / std::sqrt(bursts));
}

TEST_CASE("bus: an error frame is reported, and the frame is sent again")
{
    REPRODUCIBLE();
    bus_rig rig;
    rig.error_probability = 0.2;
    can_bus bus = make_bus(rig, test_seed());
    constexpr std::int64_t error_ns = 31000; /* flags, delimiter and interframe space */
    constexpr int count = 20000;
    constexpr std::int64_t spacing_ns = 10000000;
    int errors = 0;
    for (int i = 0; i < count; i++) {
        const std::int64_t ready_ns = i * spacing_ns;
        bus.transmit_to_loop(numbered_frame(static_cast<std::uint8_t>(i)), ready_ns);
        hal_frame frame;
        std::int64_t expected_ns = ready_ns + frame_ns;
        REQUIRE(bus.receive(ready_ns + spacing_ns - 1, frame));
        while (frame.flags & HAL_FRAME_ERROR) {
            CHECK(frame.time_ns == expected_ns);
            expected_ns += error_ns + frame_ns;
            errors++;
            REQUIRE(bus.receive(ready_ns + spacing_ns - 1, frame));
        }
        REQUIRE(frame.time_ns == expected_ns);
        REQUIRE(frame.data[0] == static_cast<std::uint8_t>(i));
        CHECK_FALSE(bus.receive(ready_ns + spacing_ns - 1, frame));
    }
    /* Errors before a success: mean p / (1 - p), variance p / (1 - p)^2. */
    CHECK(std::abs(errors / double(count) - 0.25) < 5.0 * std::sqrt(0.2 / 0.64 / count));
}

} // namespace berth
