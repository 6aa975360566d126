#include "operator_command.h"

#include "can/berth_can.h"

static int within(double value, double limit)
{
    return value >= -limit && value <= limit;
}

void operator_channel_start(struct operator_channel *channel, const struct app_config *config)
{
    *channel = (struct operator_channel){.config = &config->operator_command};
}

enum received_message operator_message(const struct operator_config *config)
{
    return config->interface == OPERATOR_INTERFACE_FORCE ? RECEIVED_OPERATOR_FORCE : RECEIVED_OPERATOR_MOTION;
}

static int receive_motion(struct operator_channel *channel, const struct hal_frame *frame)
{
    struct berth_can_operator_motion_t raw;
    if (berth_can_operator_motion_unpack(&raw, frame->data, frame->length) < 0) {
        return 0;
    }
    const struct operator_command command = {
        .position_m = berth_can_operator_motion_position_m_decode(raw.position_m),
        .velocity_m_per_s = berth_can_operator_motion_velocity_m_per_s_decode(raw.velocity_m_per_s),
        .request = raw.request,
    };
    if (!within(command.position_m, channel->config->position_limit_m) ||
        !within(command.velocity_m_per_s, channel->config->velocity_limit_m_per_s) ||
        command.request >= OPERATOR_REQUEST_COUNT) {
        return 0;
    }
    channel->command = command;
    return 1;
}

static int receive_force(struct operator_channel *channel, const struct hal_frame *frame)
{
    struct berth_can_operator_force_t raw;
    if (berth_can_operator_force_unpack(&raw, frame->data, frame->length) < 0) {
        return 0;
    }
    const struct operator_command command = {
        .force_N = berth_can_operator_force_force_n_decode(raw.force_n),
        .request = raw.request,
    };
    if (!within(command.force_N, channel->config->force_limit_N) || command.request >= OPERATOR_REQUEST_COUNT) {
        return 0;
    }
    channel->command = command;
    return 1;
}

int operator_channel_receive(struct operator_channel *channel, enum received_message message,
                             const struct hal_frame *frame)
{
    if (message != operator_message(channel->config)) {
        return 0;
    }
    return message == RECEIVED_OPERATOR_FORCE ? receive_force(channel, frame) : receive_motion(channel, frame);
}
