/* Force sensors whose samples come in several frames: pairing by counters, torn samples, late frames, axes. What the
 * bits of a frame mean is asked of cantools, in tests/python/test_sensor_layouts.py. */
#include <algorithm>
#include <doctest/doctest.h>
#include <vector>

#include "firmware/can/berth_can.h"
#include "seeded.h"
#include "sensor_bench.h"

using sensor_test::numbered;
using sensor_test::sample_period_ns;
using sensor_test::sensor_bench;

namespace
{

constexpr sensor_layout several_frames[] = {SENSOR_TWO_FRAMES_INTEL, SENSOR_TWO_FRAMES_MOTOROLA,
                                            SENSOR_THREE_FRAMES_INTEL, SENSOR_THREE_FRAMES_MOTOROLA};

} // namespace

TEST_CASE("sensor_layout: the steps in the table are those of the DBC")
{
    CHECK(sensor_layouts[SENSOR_ONE_FRAME].force_step_N == berth_can_force_force_n_decode(1));
    CHECK(sensor_layouts[SENSOR_TWO_FRAMES_INTEL].force_step_N == berth_can_wrench2i_force_fz_n_decode(1));
    CHECK(sensor_layouts[SENSOR_TWO_FRAMES_MOTOROLA].force_step_N == berth_can_wrench2m_force_fz_n_decode(1));
    CHECK(sensor_layouts[SENSOR_THREE_FRAMES_INTEL].force_step_N == berth_can_wrench3i_fz_tx_fz_n_decode(1));
    CHECK(sensor_layouts[SENSOR_THREE_FRAMES_MOTOROLA].force_step_N == berth_can_wrench3m_z_fz_n_decode(1));
    CHECK(sensor_layouts[SENSOR_TWO_FRAMES_UNNUMBERED].force_step_N ==
          doctest::Approx(berth_can_wrench2u_force_fz_n_decode(1) - berth_can_wrench2u_force_fz_n_decode(0)));
    CHECK(sensor_layouts[SENSOR_TWO_FRAMES_UNNUMBERED_SPLIT].force_step_N ==
          berth_can_wrench2s_first_fz_n_decode(1));
}

TEST_CASE("sensor_channel: a sample counts when all of its frames are there, in whatever order, on the axis chosen")
{
    for (const sensor_layout layout : several_frames) {
        for (const sensor_axis axis : {SENSOR_AXIS_X, SENSOR_AXIS_Y, SENSOR_AXIS_Z}) {
            CAPTURE(layout);
            CAPTURE(axis);
            sensor_bench bench(layout, axis);
            std::vector<hal_frame> frames = bench.frames(7);
            std::reverse(frames.begin(), frames.end());
            for (std::size_t i = 0; i < frames.size(); i++) {
                CHECK(bench.channel.samples == 0);
                CHECK(sensor_channel_is_stale(&bench.channel, 0));
                REQUIRE(bench.take(frames[i], static_cast<std::int64_t>(1000 + i)));
            }
            CHECK(bench.channel.samples == 1);
            CHECK(bench.channel.received_ns == 1000 + static_cast<std::int64_t>(frames.size()) - 1);
            CHECK_FALSE(sensor_channel_is_stale(&bench.channel, 50000000));
            CHECK(sensor_channel_is_stale(&bench.channel, 50010000));
            bench.check_newest(7);
        }
    }
}

TEST_CASE("sensor_channel: whichever frame of a sample is missing, it is never filled up by another sample's")
{
    for (const sensor_layout layout : several_frames) {
        for (std::size_t missing = 0; missing < sensor_layouts[layout].frame_count; missing++) {
            CAPTURE(layout);
            CAPTURE(missing);
            sensor_bench bench(layout);
            bench.take_all(1, 0);
            std::vector<hal_frame> torn = bench.frames(2);
            torn.erase(torn.begin() + static_cast<std::ptrdiff_t>(missing));
            for (const hal_frame &frame : torn) {
                CHECK(bench.take(frame, sample_period_ns));
            }
            bench.check_newest(1);
            CHECK(bench.channel.torn_samples == 0); /* the rest may still come */
            const std::vector<hal_frame> next = bench.frames(3);
            for (std::size_t i = 0; i + 1 < next.size(); i++) {
                CHECK(bench.take(next[i], 2 * sample_period_ns));
                bench.check_newest(1);
            }
            CHECK(bench.take(next.back(), 2 * sample_period_ns));
            bench.check_newest(3);
            CHECK(bench.channel.samples == 2);
            CHECK(bench.channel.torn_samples == 1);
            CHECK(bench.reception.counts.lost == 1);
        }
    }
}

TEST_CASE("sensor_channel: a frame that comes behind its successor's is not used, and the newer sample goes on")
{
    for (const sensor_layout layout : several_frames) {
        CAPTURE(layout);
        sensor_bench bench(layout);
        const std::vector<hal_frame> first = bench.frames(10);
        const std::vector<hal_frame> second = bench.frames(11);
        for (std::size_t i = 0; i < first.size(); i++) { /* 10a 11a 10b 11b 10c 11c */
            bench.take(first[i], 100);
            bench.take(second[i], 200);
        }
        CHECK(bench.channel.samples == 1);
        CHECK(bench.channel.torn_samples == 1);
        CHECK(bench.reception.counts.out_of_range == first.size() - 1);
        bench.check_newest(11);
    }
}

TEST_CASE("sensor_channel: the same number a whole turn of the counter later is another sample")
{
    for (const sensor_layout layout : several_frames) {
        CAPTURE(layout);
        sensor_bench bench(layout);
        const int turn = sensor_layouts[layout].frames[0].counter_mask + 1;
        const std::vector<hal_frame> before = bench.frames(5);
        const std::vector<hal_frame> after = bench.frames(numbered(9), static_cast<std::uint32_t>(5 + turn));
        bench.take(before[0], 0);
        for (std::size_t i = 1; i < after.size(); i++) {
            bench.take(after[i], turn * sample_period_ns);
        }
        CHECK(bench.channel.samples == 0);
        CHECK(bench.channel.torn_samples == 1);
    }
}

TEST_CASE("sensor_channel: after a restart of the sensor its count begins anew")
{
    for (const sensor_layout layout : several_frames) {
        CAPTURE(layout);
        sensor_bench bench(layout);
        for (int i = 0; i < 9; i++) {
            bench.take_all(i, i * sample_period_ns);
        }
        for (int i = 0; i < 3; i++) {
            bench.take_all(i, (100 + i) * sample_period_ns);
        }
        CHECK(bench.channel.samples == 12);
        CHECK(bench.channel.torn_samples == 0);
        bench.check_newest(2);
    }
}

TEST_CASE("sensor_channel: losses and frames held up at random never mix two samples")
{
    SEEDED(draw, "sensor_channel: losses*");
    for (const sensor_layout layout : several_frames) {
        CAPTURE(layout);
        sensor_bench bench(layout);
        std::vector<hal_frame> held_up;
        std::uint32_t whole = 0;
        for (int n = 0; n < 2000; n++) {
            const int number = n % 250;
            bool is_whole = true;
            std::vector<hal_frame> now = bench.frames(numbered(number), static_cast<std::uint32_t>(n));
            for (hal_frame &frame : held_up) {
                bench.take(frame, n * sample_period_ns);
            }
            held_up.clear();
            for (hal_frame &frame : now) {
                const auto lot = draw() % 20;
                is_whole &= lot > 1;
                if (lot == 1) {
                    held_up.push_back(frame);
                } else if (lot > 1) {
                    bench.take(frame, n * sample_period_ns + 1000);
                }
            }
            const std::uint32_t before = whole;
            whole += is_whole;
            if (is_whole) {
                REQUIRE(bench.channel.samples > before);
                bench.check_newest(number);
            } else { /* of one sample, whichever */
                const double first = bench.channel.wrench.force_N[0];
                bench.check_newest(static_cast<int>(std::lround(first)));
            }
        }
        CHECK(bench.channel.samples >= whole);
        CHECK(bench.channel.torn_samples > 100);
        CHECK(bench.channel.samples + bench.channel.torn_samples <= 2000);
    }
}

TEST_CASE("sensor_channel: trouble on any axis shows, whichever the loop moves along")
{
    for (int i = SENSOR_TWO_FRAMES_INTEL; i < SENSOR_LAYOUT_COUNT; i++) {
        const auto layout = static_cast<sensor_layout>(i);
        for (int axis = 0; axis < SENSOR_AXES_MAX; axis++) {
            CAPTURE(layout);
            CAPTURE(axis);
            const auto taken = [&](double force_N, bool saturated) {
                sensor_bench bench(layout, SENSOR_AXIS_X);
                wrench sample = numbered(1);
                sample.force_N[axis] = force_N;
                sample.saturated = saturated;
                for (const hal_frame &frame : bench.frames(sample, 1)) {
                    REQUIRE(bench.take(frame, 0));
                }
                return bench.channel;
            };
            /* An offset leaves a rounding in the last digit of 300. */
            CHECK_FALSE(taken(layout == SENSOR_TWO_FRAMES_UNNUMBERED ? 299.99 : 300.0, false).over_limit);
            CHECK(taken(300.1, false).over_limit);
            CHECK(taken(-300.1, false).over_limit);
            CHECK_FALSE(taken(300.0, false).saturated);
            if (layout == SENSOR_TWO_FRAMES_INTEL || layout == SENSOR_TWO_FRAMES_UNNUMBERED) { /* no bit for it */
                CHECK(taken(327.0, false).saturated);
                CHECK(taken(-327.0, false).saturated);
            } else {
                CHECK(taken(1.0, true).saturated);
            }
        }
    }
}

TEST_CASE("sensor_channel: a frame out of range is rejected, and what is left of its sample is torn")
{
    sensor_bench bench(SENSOR_TWO_FRAMES_INTEL);
    bench.take_all(1, 0);
    std::vector<hal_frame> frames = bench.frames(2);
    frames[0].data[0] = 0x00; /* -32768: no force of this sensor */
    frames[0].data[1] = 0x80;
    CHECK_FALSE(bench.take(frames[0], sample_period_ns));
    CHECK(bench.take(frames[1], sample_period_ns));
    CHECK(bench.reception.counts.out_of_range == 1);
    bench.take_all(3, 2 * sample_period_ns);
    bench.check_newest(3);
    CHECK(bench.channel.torn_samples == 1);
}

TEST_CASE("reception: of the sensor, the frames of its layout are known and no others")
{
    for (int layout = 0; layout < SENSOR_LAYOUT_COUNT; layout++) {
        const sensor_bench listening(static_cast<sensor_layout>(layout));
        for (int other = 0; other < SENSOR_LAYOUT_COUNT; other++) {
            struct reception reception = listening.reception;
            const auto made = berth::make_sensor_frames(static_cast<sensor_layout>(other), numbered(1), 1);
            for (std::size_t i = 0; i < made.count; i++) {
                const int message = reception_check(&reception, &made.frames[i]);
                CHECK(message == (layout == other ? RECEIVED_FORCE + static_cast<int>(i) : RECEIVED_NONE));
            }
        }
    }
}

TEST_CASE("reception: as many frames as the sensor's rate makes are not too many")
{
    const auto too_frequent = [](double rate_Hz, int samples) {
        sensor_bench bench(SENSOR_THREE_FRAMES_MOTOROLA, SENSOR_AXIS_Z, rate_Hz);
        for (int i = 0; i < samples; i++) {
            bench.take_all(i, i * std::int64_t{1000});
        }
        return bench.reception.counts.too_frequent;
    };
    CHECK(too_frequent(0.0, 2) == 0); /* one of them held up */
    CHECK(too_frequent(0.0, 3) == 3);
    CHECK(too_frequent(1000.0, 4) == 0);
    CHECK(too_frequent(1000.0, 5) == 3);
    CHECK(too_frequent(250.0, 2) == 0);
    CHECK(too_frequent(250.0, 3) == 3);
}
