/* A force sensor's channel behind the reception table, as the app has them, and samples that tell which one they
 * are. */
#ifndef TESTS_UNIT_SENSOR_BENCH_H
#define TESTS_UNIT_SENSOR_BENCH_H

#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

#include "firmware/reception.h"
#include "firmware/sensor_channel.h"
#include "sim_hal/hil/sensor_frames.h"

namespace sensor_test
{

constexpr std::int64_t sample_period_ns = 2500000;

/* All values of a sample tell which one it is. */
inline wrench numbered(int number)
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

} // namespace sensor_test

#endif
