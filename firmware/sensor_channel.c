#include "sensor_channel.h"

/* A frame that was held up comes behind its successor's; one further back is of another count, after a restart. */
#define LATE_SAMPLES_MAX 2

/* So long frames with the same number are of one sample: half a turn of the counter. Without a number it is the
 * pairing window. */
static int64_t number_lasts_ns(const struct app_config *config)
{
    const struct sensor_layout_row *layout = &sensor_layouts[config->sensor_channel.layout];
    return sensor_layout_is_numbered(layout)
               ? (layout->frames[0].counter_mask + 1) / 2 * config_sample_period_ns(config)
               : ns_from_ms(config->sensor_channel.pairing_window_ms);
}

void sensor_channel_start(struct sensor_channel *channel, const struct app_config *config)
{
    const struct sensor_layout_row *layout = &sensor_layouts[config->sensor_channel.layout];
    *channel = (struct sensor_channel){.config = &config->sensor_channel,
                                       .transformation = &config->wrench,
                                       .tare = &config->tare,
                                       .layout = layout,
                                       .stale_after_ns = ns_from_ms(config->sensor_channel.stale_after_ms),
                                       .counter_lasts_ns = number_lasts_ns(config),
                                       .suspected_ns = INT64_MIN / 2};
}

void sensor_channel_begin_tick(struct sensor_channel *channel)
{
    channel->has_sample = 0;
}

static uint8_t all_parts(const struct sensor_channel *channel)
{
    return (uint8_t)((1u << channel->layout->frame_count) - 1u);
}

static int is_incomplete(const struct sensor_channel *channel)
{
    return channel->parts_here != 0 && channel->parts_here != all_parts(channel);
}

/* What is left of a sample that a newer one has overtaken. */
static int is_late(const struct sensor_channel *channel, uint8_t counter, int64_t time_ns)
{
    const uint8_t behind = (uint8_t)(channel->counter - counter) & channel->layout->frames[0].counter_mask;
    return channel->parts_here != 0 && behind >= 1 && behind <= LATE_SAMPLES_MAX &&
           time_ns - channel->begun_ns <= channel->counter_lasts_ns;
}

/* The frame is another one of the sample that is coming in. */
static int belongs(const struct sensor_channel *channel, int part, uint8_t counter, int64_t time_ns)
{
    return is_incomplete(channel) && counter == channel->counter && !(channel->parts_here & (1u << part)) &&
           time_ns - channel->begun_ns <= channel->counter_lasts_ns;
}

static struct wrench in_robot_frame(const struct wrench_config *config, const struct wrench *sample)
{
    struct wrench made = {.saturated = sample->saturated};
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            made.force_N[i] += config->to_robot[6 * i + j] * sample->force_N[j];
            made.force_N[i] += config->to_robot[6 * i + 3 + j] * sample->torque_N_m[j];
            made.torque_N_m[i] += config->to_robot[6 * (i + 3) + j] * sample->force_N[j];
            made.torque_N_m[i] += config->to_robot[6 * (i + 3) + 3 + j] * sample->torque_N_m[j];
        }
    }
    return made;
}

static struct wrench without_tare(const struct tare_config *tare, const struct wrench *sample)
{
    struct wrench net = *sample;
    for (int i = 0; i < 3; i++) {
        net.force_N[i] -= tare->force_N[i];
        net.torque_N_m[i] -= tare->torque_N_m[i];
    }
    return net;
}

/* Of the sample: what the loop uses. */
static void set_wrench(struct sensor_channel *channel, const struct wrench *sample)
{
    if (channel->transformation->enabled) {
        channel->wrench = in_robot_frame(channel->transformation, sample);
        channel->force_N = channel->wrench.force_N[0];
    } else {
        channel->wrench = *sample;
        channel->force_N = sample->force_N[channel->layout->axis_count > 1 ? channel->config->axis : 0];
    }
}

/* The limit belongs to the sensor, which also carries the tool: so the tool counts. */
static void take_sample(struct sensor_channel *channel, const struct wrench *sample, int64_t time_ns)
{
    const double limit_N = channel->config->force_limit_N;
    int is_over = 0;
    for (int i = 0; i < channel->layout->axis_count; i++) {
        is_over |= !(sample->force_N[i] >= -limit_N && sample->force_N[i] <= limit_N);
    }
    if (channel->tare->enabled) {
        const struct wrench net = without_tare(channel->tare, sample);
        set_wrench(channel, &net);
    } else {
        set_wrench(channel, sample);
    }
    channel->received_ns = time_ns;
    /* Of several samples in one tick the last one counts, but none of them may hide that one was wrong. */
    channel->saturated = sample->saturated || (channel->has_sample && channel->saturated);
    channel->over_limit = is_over || (channel->has_sample && channel->over_limit);
    channel->has_sample = 1;
    channel->has_any = 1;
    channel->samples++;
}

/* A frame that is a sample by itself. */
static int receive_sample(struct sensor_channel *channel, const struct sensor_frame *row,
                          const struct hal_frame *frame)
{
    struct wrench sample = {0};
    if (!row->decode(frame->data, &sample)) {
        return 0;
    }
    take_sample(channel, &sample, frame->time_ns);
    return 1;
}

/* A frame without a number that does not go on with the sample before: that one is torn, or this frame is alone and
 * begins none. What happens within one window counts once: where two frames of a sample change places, both come
 * alone. */
static int begins_sample(struct sensor_channel *channel, int part, int64_t time_ns)
{
    const int64_t torn_ns = is_incomplete(channel) ? channel->begun_ns : time_ns;
    if ((is_incomplete(channel) || part > 0) && torn_ns - channel->suspected_ns > channel->counter_lasts_ns) {
        channel->torn_samples++;
        channel->suspected_ns = torn_ns;
    }
    channel->parts_here = 0;
    return part == 0;
}

static int receive_part(struct sensor_channel *channel, int part, const struct hal_frame *frame)
{
    const struct sensor_frame *row = &channel->layout->frames[part];
    const uint8_t counter = sensor_frame_counter(row, frame->data);
    const int goes_on = belongs(channel, part, counter, frame->time_ns);
    struct wrench parts = goes_on ? channel->parts : (struct wrench){0};
    if (is_late(channel, counter, frame->time_ns) || !row->decode(frame->data, &parts)) {
        return 0;
    }
    if (!goes_on) {
        if (row->counter_mask == 0 && !begins_sample(channel, part, frame->time_ns)) {
            return 1;
        }
        channel->torn_samples += is_incomplete(channel);
        channel->parts_here = 0;
        channel->counter = counter;
        channel->begun_ns = frame->time_ns;
    }
    channel->parts = parts;
    channel->parts_here |= (uint8_t)(1u << part);
    if (channel->parts_here == all_parts(channel)) {
        take_sample(channel, &channel->parts, frame->time_ns);
    }
    return 1;
}

int sensor_channel_receive(struct sensor_channel *channel, int part, const struct hal_frame *frame)
{
    if (frame->length != 8) {
        return 0;
    }
    return channel->layout->frame_count == 1 ? receive_sample(channel, &channel->layout->frames[0], frame)
                                             : receive_part(channel, part, frame);
}

int sensor_channel_is_stale(const struct sensor_channel *channel, int64_t now_ns)
{
    return !channel->has_any || now_ns - channel->received_ns > channel->stale_after_ns;
}
