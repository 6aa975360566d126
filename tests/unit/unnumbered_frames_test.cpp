/* Force sensors whose frames carry no number: pairing by order and arrival, suspected torn samples, and a whole loop
 * on a wire that loses, doubles and swaps frames. */
#include <doctest/doctest.h>
#include <memory>
#include <string>
#include <vector>

#include "firmware/app.h"
#include "firmware/can/berth_can.h"
#include "hal/rig/rig_file.h"
#include "seeded.h"
#include "sensor_bench.h"
#include "sim_hal/hil/sim_hal.h"

using sensor_test::sample_period_ns;
using sensor_test::sensor_bench;

namespace
{

constexpr sensor_layout without_number[] = {SENSOR_TWO_FRAMES_UNNUMBERED, SENSOR_TWO_FRAMES_UNNUMBERED_SPLIT};

/* A loop in simulation whose sensor's wire is in the test's hands. */
class loop_on_a_wire
{
  public:
    explicit loop_on_a_wire(sensor_layout layout, const std::string &layout_name)
        : layout_(layout), rig_(berth::load_rig("ess", {"sensor_channel.layout=" + layout_name})),
          hal_(berth::sim_open(rig_))
    {
        app_start(app_.get(), &rig_.firmware);
    }
    loop_on_a_wire(const loop_on_a_wire &) = delete;
    loop_on_a_wire &operator=(const loop_on_a_wire &) = delete;
    ~loop_on_a_wire() { hal_close(hal_); }

    /* One tick, in which `disturb` changes what has arrived from the sensor. */
    template <typename disturbance>
    void tick(const disturbance &disturb)
    {
        tick_input in{};
        tick_output out{};
        REQUIRE(hal_wait_tick(hal_, &in.tick) == HAL_OK);
        std::vector<hal_frame> frames = arrived(HAL_BUS_SENSOR);
        sent_N_ = frames.empty() ? 0.0 : force_N(frames.front());
        disturb(frames);
        const std::vector<hal_frame> robot = arrived(HAL_BUS_ROBOT);
        frames.insert(frames.end(), robot.begin(), robot.end());
        std::copy(frames.begin(), frames.end(), in.frames);
        in.frame_count = static_cast<std::uint32_t>(frames.size());
        REQUIRE(hal_gpio_get(hal_, HAL_LINE_EMERGENCY_STOP, &in.emergency_stop) == HAL_OK);
        REQUIRE(hal_gpio_get(hal_, HAL_LINE_ENABLE, &in.enable) == HAL_OK);
        app_step(app_.get(), &in, &out);
        for (std::uint32_t i = 0; i < out.frame_count; i++) {
            REQUIRE(hal_can_send(hal_, &out.frames[i]) == HAL_OK);
        }
    }

    /* Along z, of the sample that came in this tick. */
    double sent_N() const { return sent_N_; }
    const struct app &app() const { return *app_; }

  private:
    std::vector<hal_frame> arrived(hal_bus bus)
    {
        std::vector<hal_frame> frames;
        for (hal_frame frame{}; hal_can_receive(hal_, bus, &frame) == HAL_OK;) {
            frames.push_back(frame);
        }
        return frames;
    }

    double force_N(const hal_frame &first) const
    {
        if (layout_ == SENSOR_TWO_FRAMES_UNNUMBERED) {
            berth_can_wrench2u_force_t raw{};
            REQUIRE(berth_can_wrench2u_force_unpack(&raw, first.data, first.length) == 0);
            return berth_can_wrench2u_force_fz_n_decode(raw.fz_n);
        }
        berth_can_wrench2s_first_t raw{};
        REQUIRE(berth_can_wrench2s_first_unpack(&raw, first.data, first.length) == 0);
        return berth_can_wrench2s_first_fz_n_decode(raw.fz_n);
    }

    sensor_layout layout_;
    berth::rig rig_;
    std::unique_ptr<struct app> app_ = std::make_unique<struct app>();
    struct hal *hal_;
    double sent_N_ = 0.0;
};

} // namespace

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
            const std::int64_t at_ns = n * sample_period_ns;
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
        bench.take(bench.frames(1)[0], 4000 * sample_period_ns);
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

TEST_CASE("unnumbered frames: a loop runs on over lost, doubled and swapped ones, and never mixes two samples")
{
    using frames_of_tick = std::vector<hal_frame>;
    const struct {
        const char *name;
        void (*disturb)(frames_of_tick &frames);
        bool is_used;
        std::uint32_t suspected;
    } faults[] = {
        {"first lost", [](frames_of_tick &frames) { frames.erase(frames.begin()); }, false, 1},
        {"second lost", [](frames_of_tick &frames) { frames.pop_back(); }, false, 1},
        {"swapped",
         [](frames_of_tick &frames) {
             std::swap(frames[0], frames[1]);
             std::swap(frames[0].time_ns, frames[1].time_ns);
         },
         false, 1},
        {"first doubled", [](frames_of_tick &frames) { frames.insert(frames.begin(), frames[0]); }, true, 1},
        {"second doubled", [](frames_of_tick &frames) { frames.push_back(frames[1]); }, true, 1},
        {"second later than the window", [](frames_of_tick &frames) { frames[0].time_ns -= 400000; }, false, 1},
        {"both lost", [](frames_of_tick &frames) { frames.clear(); }, false, 0},
    };
    constexpr int rounds = 5, ticks_between = 20;
    const std::pair<sensor_layout, const char *> layouts[] = {
        {SENSOR_TWO_FRAMES_UNNUMBERED, "two_frames_unnumbered"},
        {SENSOR_TWO_FRAMES_UNNUMBERED_SPLIT, "two_frames_unnumbered_split"}};
    for (const auto &one : layouts) {
        const sensor_layout layout = one.first;
        const char *const name = one.second;
        CAPTURE(name);
        loop_on_a_wire loop(layout, name);
        const auto undisturbed = [](frames_of_tick &) {};
        while (loop.app().supervisor.state != SUPERVISOR_RUNNING) {
            loop.tick(undisturbed);
        }
        std::uint32_t suspected = 0, samples = loop.app().sensor_channel.samples;
        double force_max_N = 0.0;
        REQUIRE(loop.app().sensor_channel.torn_samples == 0);
        for (int round = 0; round < rounds; round++) {
            for (const auto &fault : faults) {
                CAPTURE(fault.name);
                for (int i = 0; i < ticks_between; i++) {
                    const double before_N = loop.app().sensor_channel.force_N;
                    const bool is_faulty = i == ticks_between / 2;
                    loop.tick([&](frames_of_tick &frames) {
                        REQUIRE(frames.size() == 2);
                        is_faulty ? fault.disturb(frames) : undisturbed(frames);
                    });
                    const bool is_used = !is_faulty || fault.is_used;
                    CHECK(loop.app().sensor_channel.force_N == (is_used ? loop.sent_N() : before_N));
                    samples += is_used;
                    force_max_N = std::max(force_max_N, std::abs(loop.sent_N()));
                }
                suspected += fault.suspected;
                CHECK(loop.app().sensor_channel.samples == samples);
                CHECK(loop.app().recorder.tick.torn_samples == suspected);
            }
        }
        CHECK(force_max_N > 10.0);
        CHECK(loop.app().supervisor.state == SUPERVISOR_RUNNING);
        CHECK(loop.app().reception.counts.lost == 0);
    }
}
