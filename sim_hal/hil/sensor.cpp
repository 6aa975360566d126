#include "sensor.h"

#include <cmath>

#include "../../firmware/can/codec.h"
#include "../effects/active.h"

namespace berth
{

sensor::sensor(const rig &rig)
    : rig_(rig.sensor), random_(rig.run.seed, stream_sensor), spikes_(rig.run.seed, stream_spikes),
      spike_probability_(value_of_effect(rig, "sensor.spike_probability")),
      spike_N_(value_of_effect(rig, "sensor.spike_N")), stages_(active_stages(rig, &effect::on_samples)),
      layout_(static_cast<sensor_layout>(rig.firmware.sensor_channel.layout)),
      axis_(sensor_layouts[layout_].axis_count > 1 ? static_cast<std::size_t>(rig.firmware.sensor_channel.axis) : 0),
      sample_period_ns_(config_sample_period_ns(&rig.firmware)), delay_ns_(ns_from_ms(rig.sensor.delay_ms)),
      next_sample_ns_(ns_from_ms(rig.sensor.sample_phase_ms))
{
    rig_.saturation_N = std::min(rig_.saturation_N, sensor_layouts[layout_].force_max_N);
}

double sensor::shown_N(double force_N, double time_s)
{
    for (auto &stage : stages_) {
        force_N = stage->take(force_N, time_s);
    }
    if (spikes_.happens(spike_probability_)) {
        const double size_N = spike_N_ * (0.8 + 0.4 * spikes_.uniform());
        force_N += spikes_.uniform() < 0.5 ? -size_N : size_N;
    }
    force_N += rig_.bias_N;
    if (rig_.noise_N > 0.0) {
        force_N += rig_.noise_N * random_.normal();
    }
    if (rig_.resolution_N > 0.0) {
        force_N = rig_.resolution_N * std::round(force_N / rig_.resolution_N);
    }
    is_saturated_ = false;
    return codec_saturate(force_N, rig_.saturation_N, &is_saturated_);
}

void sensor::sample(double force_N, can_bus &bus, bool is_lost)
{
    const std::int64_t sampled_ns = next_sample_ns_;
    next_sample_ns_ += sample_period_ns_;
    if (is_silent_ || random_.happens(rig_.loss_probability) || is_lost) {
        counter_++;
        return;
    }
    if (!(newest_.count > 0 && random_.happens(rig_.stale_probability))) {
        wrench sample{};
        sample.force_N[axis_] = shown_N(force_N, static_cast<double>(sampled_ns) * 1e-9);
        sample.saturated = is_saturated_;
        newest_ = make_sensor_frames(layout_, sample, counter_++);
    }
    const std::int64_t frame_ns = bus.frame_time_ns(8);
    const auto count = static_cast<std::int64_t>(newest_.count);
    for (std::int64_t i = 0; i < count; i++) {
        bus.transmit_to_loop(newest_.frames[static_cast<std::size_t>(i)],
                             sampled_ns + delay_ns_ - (count - i) * frame_ns);
    }
}

} // namespace berth
