#include "sensor_channel.h"

#include "can/berth_can.h"

void sensor_channel_start(struct sensor_channel *channel, const struct app_config *config)
{
    *channel = (struct sensor_channel){.config = &config->sensor_channel};
}

void sensor_channel_begin_tick(struct sensor_channel *channel)
{
    channel->has_sample = 0;
}

int sensor_channel_receive(struct sensor_channel *channel, const struct hal_frame *frame)
{
    struct berth_can_force_t raw;
    if (berth_can_force_unpack(&raw, frame->data, frame->length) < 0 ||
        !berth_can_force_force_n_is_in_range(raw.force_n)) {
        return 0;
    }
    const double limit_N = channel->config->force_limit_N;
    channel->force_N = berth_can_force_force_n_decode(raw.force_n);
    channel->received_ns = frame->time_ns;
    /* Of several samples in one tick the last one counts, but none of them may hide that one was wrong. */
    const int is_over = !(channel->force_N >= -limit_N && channel->force_N <= limit_N);
    channel->saturated = raw.saturated || (channel->has_sample && channel->saturated);
    channel->over_limit = is_over || (channel->has_sample && channel->over_limit);
    channel->has_sample = 1;
    return 1;
}
