#include "operator_command.h"

#include "can/berth_can.h"

static int within(double value, double limit)
{
    return value >= -limit && value <= limit;
}

void operator_channel_start(struct operator_channel *channel, const struct app_config *config)
{
    *channel = (struct operator_channel){.config = &config->operator_command,
                                         .arm = &config->arm,
                                         .message = operator_message(&config->operator_command)};
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
    if (message != channel->message) {
        return 0;
    }
    return message == RECEIVED_OPERATOR_FORCE ? receive_force(channel, frame) : receive_motion(channel, frame);
}

static int receive_joint(const struct operator_channel *channel, const struct hal_frame *frame,
                         struct arm_order *order)
{
    static const int32_t kinds[] = {ARM_ORDER_JOINT_RATE, ARM_ORDER_JOINT_MOVE, ARM_ORDER_FOLLOW};
    struct berth_can_operator_joint_t raw;
    if (berth_can_operator_joint_unpack(&raw, frame->data, frame->length) < 0 ||
        raw.order >= sizeof kinds / sizeof kinds[0] || raw.joint >= channel->arm->joint_count) {
        return 0;
    }
    const struct arm_joint *joint = &channel->arm->joints[raw.joint];
    *order = (struct arm_order){
        .kind = kinds[raw.order],
        .joint = raw.joint,
        .rate_rad_per_s = berth_can_operator_joint_rate_rad_per_s_decode(raw.rate_rad_per_s),
        .angle_rad = berth_can_operator_joint_angle_rad_decode(raw.angle_rad),
    };
    if (order->kind != ARM_ORDER_JOINT_MOVE) {
        return 1;
    }
    /* The end of a joint's range may lie between two angles that the wire has, or its decoding round beside it. */
    const double half_step_rad = 0.5 * berth_can_operator_joint_angle_rad_decode(1);
    if (!(order->angle_rad >= joint->angle_min_rad - half_step_rad &&
          order->angle_rad <= joint->angle_max_rad + half_step_rad && order->rate_rad_per_s >= 0.0)) {
        return 0;
    }
    order->angle_rad = order->angle_rad < joint->angle_min_rad ? joint->angle_min_rad : order->angle_rad;
    order->angle_rad = order->angle_rad > joint->angle_max_rad ? joint->angle_max_rad : order->angle_rad;
    return 1;
}

static int receive_line(const struct hal_frame *frame, struct arm_order *order)
{
    struct berth_can_operator_line_t raw;
    if (berth_can_operator_line_unpack(&raw, frame->data, frame->length) < 0) {
        return 0;
    }
    *order = (struct arm_order){
        .kind = ARM_ORDER_LINE,
        .way_m = {berth_can_operator_line_x_m_decode(raw.x_m), berth_can_operator_line_y_m_decode(raw.y_m),
                  berth_can_operator_line_z_m_decode(raw.z_m)},
        .speed_m_per_s = berth_can_operator_line_speed_m_per_s_decode(raw.speed_m_per_s),
    };
    return order->speed_m_per_s > 0.0;
}

int operator_channel_receive_order(const struct operator_channel *channel, enum received_message message,
                                   const struct hal_frame *frame, struct arm_order *order)
{
    return message == RECEIVED_OPERATOR_LINE ? receive_line(frame, order) : receive_joint(channel, frame, order);
}
