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
      period_ns_(config_period_ns(&rig.firmware)), delay_ns_(ns_from_ms(rig.sensor.delay_ms)),
      next_sample_ns_(ns_from_ms(rig.sensor.sample_phase_ms))
{
    rig_.saturation_N = std::min(rig_.saturation_N, CAN_FORCE_MAX_N);
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
    next_sample_ns_ += period_ns_;
    if (is_silent_ || random_.happens(rig_.loss_probability) || is_lost) {
        counter_++;
        return;
    }
    if (!(newest_.length > 0 && random_.happens(rig_.stale_probability))) {
        const double step_N = berth_can_force_force_n_decode(1);
        berth_can_force_t raw{};
        raw.force_n = berth_can_force_force_n_encode(
            codec_round(shown_N(force_N, static_cast<double>(sampled_ns) * 1e-9), step_N));
        raw.saturated = is_saturated_;
        raw.counter = counter_++;
        newest_ = {0, BERTH_CAN_FORCE_FRAME_ID, HAL_BUS_SENSOR, BERTH_CAN_FORCE_LENGTH, 0, 0, {}};
        if (berth_can_force_pack(newest_.data, &raw, sizeof newest_.data) < 0) {
            return;
        }
    }
    bus.transmit_to_loop(newest_, sampled_ns + delay_ns_ - bus.frame_time_ns(newest_.length));
}

} // namespace berth
