#include "robot_channel.h"

#include <string.h>

#include "can/codec.h"

#define STATE_BIT(state) (1u << (state))

/* Ten status frames a second: enough for a person, 0.1 % of the bus. */
#define STATUS_RATE_HZ 10

struct transmission_row {
    uint32_t id;
    uint32_t allowed_states;
};

/* The robot gets setpoints from the moment that its feedback is known to be near them. In fault they lead it to
 * rest and hold it there, with motion_allowed cleared. */
static const struct transmission_row setpoint_row = {
    BERTH_CAN_SETPOINT_FRAME_ID, STATE_BIT(SUPERVISOR_READY) | STATE_BIT(SUPERVISOR_RUNNING) |
                                     STATE_BIT(SUPERVISOR_HOLDING) | STATE_BIT(SUPERVISOR_FAULT)};
static const struct transmission_row status_row = {BERTH_CAN_LOOP_STATUS_FRAME_ID, ~0u};

void robot_channel_start(struct robot_channel *channel, const struct app_config *config)
{
    const int64_t period_ticks = NS_PER_S / STATUS_RATE_HZ / config_period_ns(config);
    *channel = (struct robot_channel){.status_period_ticks = period_ticks > 0 ? period_ticks : 1};
}

void robot_channel_begin_tick(struct robot_channel *channel)
{
    channel->has_feedback = 0;
}

int robot_channel_receive(struct robot_channel *channel, const struct hal_frame *frame)
{
    struct berth_can_robot_feedback_t raw;
    if (berth_can_robot_feedback_unpack(&raw, frame->data, frame->length) < 0 ||
        !berth_can_robot_feedback_position_m_is_in_range(raw.position_m)) {
        return 0;
    }
    channel->position_m = berth_can_robot_feedback_position_m_decode(raw.position_m);
    channel->fault = raw.fault || (channel->has_feedback && channel->fault);
    channel->has_feedback = 1;
    return 1;
}

/* Appends a frame with `data`, unless `row` forbids it in this state. Returns the number of frames appended. */
static int send_frame(struct tick_output *out, const struct transmission_row *row,
                      const struct supervisor *supervisor, const struct hal_tick *tick, const uint8_t data[8])
{
    if (!(row->allowed_states & STATE_BIT(supervisor->state)) || out->frame_count >= TICK_FRAMES_OUT_MAX) {
        return 0;
    }
    struct hal_frame *frame = &out->frames[out->frame_count++];
    *frame = (struct hal_frame){.time_ns = tick->scheduled_ns, .id = row->id, .bus = HAL_BUS_ROBOT, .length = 8};
    memcpy(frame->data, data, sizeof frame->data);
    return 1;
}

static double send_setpoint(struct robot_channel *channel, const struct supervisor *supervisor,
                            const struct hal_tick *tick, double command_position_m, struct tick_output *out)
{
    bool saturated = false;
    const double position_m = codec_saturate(command_position_m, CAN_POSITION_MAX_m, &saturated);
    const double step_m = berth_can_setpoint_position_m_decode(1);
    const struct berth_can_setpoint_t raw = {
        .position_m = berth_can_setpoint_position_m_encode(codec_round(position_m, step_m)),
        .motion_allowed = (uint8_t)supervisor_may_move(supervisor),
        .counter = channel->setpoint_counter,
    };
    uint8_t data[8];
    if (berth_can_setpoint_pack(data, &raw, sizeof data) == (int)sizeof data &&
        send_frame(out, &setpoint_row, supervisor, tick, data)) {
        channel->setpoint_counter++;
        channel->saturated_setpoints += saturated;
    }
    return berth_can_setpoint_position_m_decode(raw.position_m);
}

static void send_status(struct robot_channel *channel, const struct supervisor *supervisor,
                        const struct hal_tick *tick, uint32_t limits, uint32_t missed_ticks, struct tick_output *out)
{
    const struct berth_can_loop_status_t raw = {
        .state = (uint8_t)supervisor->state,
        .stop_cause = (uint8_t)supervisor->stop_cause,
        .limits = (uint8_t)limits,
        .missed_ticks = missed_ticks < UINT16_MAX ? (uint16_t)missed_ticks : UINT16_MAX,
        .counter = channel->status_counter,
    };
    uint8_t data[8];
    if (berth_can_loop_status_pack(data, &raw, sizeof data) == (int)sizeof data) {
        channel->status_counter += (uint8_t)send_frame(out, &status_row, supervisor, tick, data);
    }
}

double robot_channel_send(struct robot_channel *channel, const struct supervisor *supervisor,
                          const struct hal_tick *tick, double command_position_m, uint32_t limits,
                          uint32_t missed_ticks, struct tick_output *out)
{
    const double sent_position_m = send_setpoint(channel, supervisor, tick, command_position_m, out);
    if (tick->index % channel->status_period_ticks == 0) {
        send_status(channel, supervisor, tick, limits, missed_ticks, out);
    }
    return sent_position_m;
}
