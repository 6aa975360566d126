#include "sensor.h"

#include <cmath>

#include "../../firmware/can/codec.h"
#include "../../hal/rig/tool_load.h"
#include "../effects/active.h"

namespace berth
{

sensor::sensor(const rig &rig)
    : rig_(rig.sensor), wrench_(rig.wrench), tool_(tool_load(rig.tool)), shown_(shown_wrench(rig.wrench)),
      shows_wrench_(rig.firmware.wrench.enabled != 0), random_(rig.run.seed, stream_sensor),
      spikes_(rig.run.seed, stream_spikes), spike_probability_(value_of_effect(rig, "sensor.spike_probability")),
      spike_N_(value_of_effect(rig, "sensor.spike_N")), stages_(active_stages(rig, &effect::on_samples)),
      layout_(static_cast<sensor_layout>(rig.firmware.sensor_channel.layout)),
      axis_(sensor_layouts[layout_].axis_count > 1 ? static_cast<std::size_t>(rig.firmware.sensor_channel.axis) : 0),
      sample_period_ns_(config_sample_period_ns(&rig.firmware)), delay_ns_(ns_from_ms(rig.sensor.delay_ms)),
      next_sample_ns_(ns_from_ms(rig.sensor.sample_phase_ms))
{
    rig_.saturation_N = std::min(rig_.saturation_N, sensor_layouts[layout_].force_max_N);
}

/* What the electronics get to see of a force. */
double sensor::felt_N(double force_N, double time_s)
{
    for (auto &stage : stages_) {
        force_N = stage->take(force_N, time_s);
    }
    if (spikes_.happens(spike_probability_)) {
        const double size_N = spike_N_ * (0.8 + 0.4 * spikes_.uniform());
        force_N += spikes_.uniform() < 0.5 ? -size_N : size_N;
    }
    return force_N + rig_.bias_N;
}

double sensor::electronics(double value, double noise, double resolution, double saturation)
{
    if (noise > 0.0) {
        value += noise * random_.normal();
    }
    if (resolution > 0.0) {
        value = resolution * std::round(value / resolution);
    }
    return codec_saturate(value, saturation, &is_saturated_);
}

double sensor::shown_N(double force_N, double time_s)
{
    is_saturated_ = false;
    return electronics(felt_N(force_N, time_s) + tool_[axis_], rig_.noise_N, rig_.resolution_N, rig_.saturation_N);
}

wrench sensor::shown(const whole_load &load, double time_s)
{
    wrench sample{};
    if (!shows_wrench_) {
        sample.force_N[axis_] = shown_N(load[0], time_s);
        sample.saturated = is_saturated_;
        return sample;
    }
    std::array<double, 6> felt = load;
    felt[0] = felt_N(load[0], time_s);
    is_saturated_ = false;
    for (std::size_t i = 0; i < 6; i++) {
        double value = tool_[i];
        for (std::size_t j = 0; j < 6; j++) {
            value += shown_[6 * i + j] * felt[j];
        }
        if (i < 3) {
            sample.force_N[i] = electronics(value, rig_.noise_N, rig_.resolution_N, rig_.saturation_N);
        } else {
            sample.torque_N_m[i - 3] =
                electronics(value, wrench_.torque_noise_N_m, 0.0, sensor_layouts[layout_].torque_max_N_m);
        }
    }
    sample.saturated = is_saturated_;
    return sample;
}

void sensor::sample(const whole_load &load, can_bus &bus, bool is_lost)
{
    const std::int64_t sampled_ns = next_sample_ns_;
    next_sample_ns_ += sample_period_ns_;
    if (is_silent_ || random_.happens(rig_.loss_probability) || is_lost) {
        counter_++;
        return;
    }
    if (!(newest_.count > 0 && random_.happens(rig_.stale_probability))) {
        newest_ = make_sensor_frames(layout_, shown(load, static_cast<double>(sampled_ns) * 1e-9), counter_++);
    }
    const std::int64_t frame_ns = bus.frame_time_ns(8);
    const auto count = static_cast<std::int64_t>(newest_.count);
    for (std::int64_t i = 0; i < count; i++) {
        bus.transmit_to_loop(newest_.frames[static_cast<std::size_t>(i)],
                             sampled_ns + delay_ns_ - (count - i) * frame_ns);
    }
}

} // namespace berth
