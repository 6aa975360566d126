/* Force sensors whose samples come in several frames: pairing by counters, torn samples, late frames, axes. What the
 * bits of a frame mean is asked of cantools, in tests/python/test_sensor_layouts.py. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <vector>

#include "firmware/can/berth_can.h"
#include "firmware/reception.h"
#include "firmware/sensor_channel.h"
#include "seeded.h"
#include "sim_hal/hil/sensor_frames.h"

namespace
{

constexpr sensor_layout several_frames[] = {SENSOR_TWO_FRAMES_INTEL, SENSOR_TWO_FRAMES_MOTOROLA,
                                            SENSOR_THREE_FRAMES_INTEL, SENSOR_THREE_FRAMES_MOTOROLA};
constexpr sensor_layout without_number[] = {SENSOR_TWO_FRAMES_UNNUMBERED, SENSOR_TWO_FRAMES_UNNUMBERED_SPLIT};

/* All values of a sample tell which one it is. */
wrench numbered(int number)
{
    wrench sample{};
    for (int i = 0; i < SENSOR_AXES_MAX; i++) {
        sample.force_N[i] = number + 0.2 * i;
        sample.torque_N_m[i] = 0.01 * number + 0.002 * i;
    }
    return sample;
}

/* Reception table and channel as the app has them. */
class sensor_bench
{
  public:
    explicit sensor_bench(sensor_layout layout, sensor_axis axis = SENSOR_AXIS_Z, double rate_Hz = 0.0)
    {
        config.sensor_channel.layout = layout;
        config.sensor_channel.axis = axis;
        config.sensor_channel.rate_Hz = rate_Hz;
        config.sensor_channel.force_limit_N = 300.0;
        REQUIRE(config_validate(&config).key == nullptr);
        reception_start(&reception, &config);
        sensor_channel_start(&channel, &config);
        reception_begin_tick(&reception, 0, 0);
        sensor_channel_begin_tick(&channel);
    }

    std::vector<hal_frame> frames(const wrench &sample, std::uint32_t counter) const
    {
        const auto made = berth::make_sensor_frames(layout(), sample, counter);
        REQUIRE(made.count == sensor_layouts[layout()].frame_count);
        return {made.frames.begin(), made.frames.begin() + static_cast<std::ptrdiff_t>(made.count)};
    }
    std::vector<hal_frame> frames(int number) const
    {
        return frames(numbered(number), static_cast<std::uint32_t>(number));
    }

    bool take(hal_frame frame, std::int64_t time_ns)
    {
        frame.time_ns = time_ns;
        reception.now_ns = std::max(reception.now_ns, time_ns);
        const received_message message = reception_check(&reception, &frame);
        if (message == RECEIVED_NONE) {
            return false;
        }
        if (!sensor_channel_receive(&channel, message - RECEIVED_FORCE, &frame)) {
            reception_reject_range(&reception);
            return false;
        }
        reception_accept(&reception, message, &frame);
        return true;
    }

    /* A whole sample. */
    void take_all(int number, std::int64_t time_ns)
    {
        for (const hal_frame &frame : frames(number)) {
            take(frame, time_ns);
        }
    }

    /* The newest whole sample, all of its values of one and the same. */
    void check_newest(int number) const
    {
        const wrench expected = numbered(number);
        const double step_N = sensor_layouts[layout()].force_step_N;
        for (int i = 0; i < SENSOR_AXES_MAX; i++) {
            CHECK(std::abs(channel.wrench.force_N[i] - expected.force_N[i]) <= 0.51 * step_N);
            CHECK(std::abs(channel.wrench.torque_N_m[i] - expected.torque_N_m[i]) <= 0.51e-3);
        }
        CHECK(channel.force_N == channel.wrench.force_N[config.sensor_channel.axis]);
    }

    sensor_layout layout() const { return static_cast<sensor_layout>(config.sensor_channel.layout); }

    app_config config = config_default();
    struct reception reception {
    };
    sensor_channel channel{};
};

constexpr std::int64_t period_ns = 2500000;

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
                CHECK(bench.take(frame, period_ns));
            }
            bench.check_newest(1);
            CHECK(bench.channel.torn_samples == 0); /* the rest may still come */
            const std::vector<hal_frame> next = bench.frames(3);
            for (std::size_t i = 0; i + 1 < next.size(); i++) {
                CHECK(bench.take(next[i], 2 * period_ns));
                bench.check_newest(1);
            }
            CHECK(bench.take(next.back(), 2 * period_ns));
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
            bench.take(after[i], turn * period_ns);
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
            bench.take_all(i, i * period_ns);
        }
        for (int i = 0; i < 3; i++) {
            bench.take_all(i, (100 + i) * period_ns);
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
                bench.take(frame, n * period_ns);
            }
            held_up.clear();
            for (hal_frame &frame : now) {
                const auto lot = draw() % 20;
                is_whole &= lot > 1;
                if (lot == 1) {
                    held_up.push_back(frame);
                } else if (lot > 1) {
                    bench.take(frame, n * period_ns + 1000);
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

TEST_CASE("sensor_channel: frames without a number are one sample in their order and within the window")
{
    constexpr std::int64_t us = 1000;
    constexpr std::int64_t next = 2500; /* the sample after, in us */
    struct arrival {
        int number; /* of the sample */
        int part;
        std::int64_t time_us;
    };
    const struct {
        const char *name;
        std::vector<arrival> arrivals;
        std::uint32_t samples, suspected;
        int newest;
    } cases[] = {
        {"back to back", {{1, 0, 0}, {1, 1, 135}, {2, 0, next}, {2, 1, next + 135}}, 2, 0, 2},
        {"both at once", {{1, 0, 0}, {1, 1, 0}}, 1, 0, 1},
        {"second at the end of the window", {{1, 0, 0}, {1, 1, 500}}, 1, 0, 1},
        {"late second", {{1, 0, 0}, {1, 1, 501}, {2, 0, next}, {2, 1, next + 135}}, 1, 1, 2},
        {"lost second", {{1, 0, 0}, {2, 0, next}, {2, 1, next + 135}}, 1, 1, 2},
        {"lost first", {{1, 1, 135}, {2, 0, next}, {2, 1, next + 135}}, 1, 1, 2},
        {"lost first of the second", {{1, 0, 0}, {1, 1, 135}, {2, 1, next + 135}, {3, 0, 2 * next}}, 1, 1, 1},
        {"swapped", {{1, 1, 0}, {1, 0, 135}, {2, 0, next}, {2, 1, next + 135}}, 1, 1, 2},
        {"swapped twice", {{1, 1, 0}, {1, 0, 135}, {2, 1, next}, {2, 0, next + 135}, {3, 0, 2 * next}}, 0, 2, 0},
        {"doubled first", {{1, 0, 0}, {1, 0, 135}, {1, 1, 270}}, 1, 1, 1},
        {"doubled second", {{1, 0, 0}, {1, 1, 135}, {1, 1, 270}, {2, 0, next}, {2, 1, next + 135}}, 2, 1, 2},
        {"second held up until the next sample comes",
         {{1, 0, 0}, {1, 1, next - 10}, {2, 0, next}, {2, 1, next + 135}},
         1,
         1,
         2},
        {"lost second and lost first of the next: one gap",
         {{1, 0, 0}, {2, 1, next + 135}, {3, 0, 2 * next}},
         0,
         1,
         0},
        /* What nobody can see. */
        {"lost sample", {{1, 0, 0}, {1, 1, 135}, {3, 0, 2 * next}, {3, 1, 2 * next + 135}}, 2, 0, 3},
        {"doubled sample", {{1, 0, 0}, {1, 1, 135}, {1, 0, 270}, {1, 1, 405}}, 2, 0, 1},
    };
    for (const sensor_layout layout : without_number) {
        for (const auto &row : cases) {
            CAPTURE(layout);
            CAPTURE(row.name);
            sensor_bench bench(layout);
            for (const arrival &frame : row.arrivals) {
                CHECK(bench.take(bench.frames(frame.number)[static_cast<std::size_t>(frame.part)],
                                 frame.time_us * us));
            }
            CHECK(bench.channel.samples == row.samples);
            CHECK(bench.channel.torn_samples == row.suspected);
            CHECK(bench.channel.has_any == (row.samples > 0));
            if (row.newest > 0) {
                bench.check_newest(row.newest);
            }
            CHECK(bench.reception.counts.lost == 0);
        }
    }
}

TEST_CASE("sensor_channel: a frame of the next sample inside the window is taken for this one's, as the guide says")
{
    for (const sensor_layout layout : without_number) {
        CAPTURE(layout);
        sensor_bench bench(layout);
        bench.take(bench.frames(1)[0], 0);
        bench.take(bench.frames(2)[1], 400000); /* a sensor that sends in bursts */
        CHECK(bench.channel.samples == 1);
        CHECK(bench.channel.torn_samples == 0);
        CHECK(bench.channel.wrench.force_N[0] == doctest::Approx(1.0));
        CHECK(bench.channel.wrench.torque_N_m[1] == doctest::Approx(0.022));
    }
}

TEST_CASE("sensor_channel: without a number, losses and frames held up never mix samples, and each counts once")
{
    SEEDED(draw, "sensor_channel: without a number, losses*");
    for (const sensor_layout layout : without_number) {
        CAPTURE(layout);
        sensor_bench bench(layout);
        std::uint32_t whole = 0, torn = 0, unseen = 0;
        bool tore_before = false;
        for (int n = 0; n < 4000; n++) {
            const int number = n % 250;
            std::vector<hal_frame> frames = bench.frames(number);
            bool here[2] = {draw() % 20 != 0, draw() % 20 != 0};
            const bool is_late = draw() % 20 == 0;
            const std::int64_t at_ns = n * period_ns;
            if (here[0]) {
                bench.take(frames[0], at_ns);
            }
            if (here[1]) {
                bench.take(frames[1], at_ns + (is_late ? 501000 + draw() % 1900000 : draw() % 500001));
            }
            const bool is_whole = here[0] && here[1] && !is_late;
            const bool is_torn = !is_whole && (here[0] || here[1]);
            whole += is_whole;
            torn += is_torn;
            unseen += is_torn && tore_before; /* the end of one and the begin of the next may look like one */
            tore_before = is_torn;
            if (is_whole) {
                bench.check_newest(number);
            }
        }
        bench.take(bench.frames(1)[0], 4000 * period_ns);
        CHECK(bench.channel.samples == whole);
        CHECK(bench.channel.torn_samples <= torn);
        CHECK(bench.channel.torn_samples + unseen >= torn);
        CHECK(torn > 300);
    }
}

TEST_CASE("sensor_channel: of a response that is no force, nothing is taken")
{
    sensor_bench bench(SENSOR_TWO_FRAMES_UNNUMBERED_SPLIT);
    std::vector<hal_frame> frames = bench.frames(1);
    frames[0].data[0] = 17;
    CHECK_FALSE(bench.take(frames[0], 0));
    CHECK(bench.take(frames[1], 135000));
    CHECK(bench.channel.samples == 0);
    CHECK(bench.channel.torn_samples == 1);
    CHECK(bench.reception.counts.out_of_range == 1);
}

TEST_CASE("config: frames without a number need a window that the next sample stays outside of")
{
    const struct {
        sensor_layout layout;
        double rate_Hz, window_ms;
        bool is_valid;
    } cases[] = {
        {SENSOR_TWO_FRAMES_UNNUMBERED, 1000.0, 0.5, true}, {SENSOR_TWO_FRAMES_UNNUMBERED, 1000.0, 0.500001, false},
        {SENSOR_TWO_FRAMES_UNNUMBERED, 0.0, 1.25, true},   {SENSOR_TWO_FRAMES_UNNUMBERED, 0.0, 1.2501, false},
        {SENSOR_TWO_FRAMES_INTEL, 2000.0, 0.5, true},      {SENSOR_TWO_FRAMES_UNNUMBERED, 2000.0, 0.5, false},
        {SENSOR_TWO_FRAMES_UNNUMBERED, 0.0, 0.0, false},   {SENSOR_ONE_FRAME, 0.0, -1.0, false},
    };
    for (const auto &row : cases) {
        CAPTURE(row.rate_Hz);
        CAPTURE(row.window_ms);
        app_config config = config_default();
        config.sensor_channel.layout = row.layout;
        config.sensor_channel.rate_Hz = row.rate_Hz;
        config.sensor_channel.pairing_window_ms = row.window_ms;
        const char *key = config_validate(&config).key;
        CHECK((key == nullptr) == row.is_valid);
        CHECK((row.is_valid || key == std::string("sensor_channel.pairing_window_ms")));
    }
}

TEST_CASE("sensor_channel: a frame out of range is rejected, and what is left of its sample is torn")
{
    sensor_bench bench(SENSOR_TWO_FRAMES_INTEL);
    bench.take_all(1, 0);
    std::vector<hal_frame> frames = bench.frames(2);
    frames[0].data[0] = 0x00; /* -32768: no force of this sensor */
    frames[0].data[1] = 0x80;
    CHECK_FALSE(bench.take(frames[0], period_ns));
    CHECK(bench.take(frames[1], period_ns));
    CHECK(bench.reception.counts.out_of_range == 1);
    bench.take_all(3, 2 * period_ns);
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
