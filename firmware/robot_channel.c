#include "robot_channel.h"

#include "can/codec.h"
#include "transmission.h"

/* Ten status frames a second: enough for a person, 0.1 % of the bus. */
#define STATUS_RATE_HZ 10

/* The robot gets setpoints from the moment that its feedback is known to be near them. In fault they lead it to
 * rest and hold it there, with motion_allowed cleared. */
#define SETPOINT_STATES                                                                                             \
    (STATE_BIT(SUPERVISOR_READY) | STATE_BIT(SUPERVISOR_RUNNING) | STATE_BIT(SUPERVISOR_HOLDING) |                  \
     STATE_BIT(SUPERVISOR_FAULT))
static const struct transmission_row setpoint_row = {BERTH_CAN_SETPOINT_FRAME_ID, BERTH_CAN_SETPOINT_LENGTH,
                                                     SETPOINT_STATES};

/* Of the axes beside that of the loop. Their frames are laid out as that of the loop's, in both directions, so one
 * codec serves all of them. */
static const struct transmission_row side_rows[SIDE_AXIS_COUNT] = {
    [SIDE_AXIS_Y] = {BERTH_CAN_SETPOINT_Y_FRAME_ID, BERTH_CAN_SETPOINT_Y_LENGTH, SETPOINT_STATES},
    [SIDE_AXIS_Z] = {BERTH_CAN_SETPOINT_Z_FRAME_ID, BERTH_CAN_SETPOINT_Z_LENGTH, SETPOINT_STATES},
    [SIDE_AXIS_RX] = {BERTH_CAN_SETPOINT_RX_FRAME_ID, BERTH_CAN_SETPOINT_RX_LENGTH, SETPOINT_STATES},
    [SIDE_AXIS_RY] = {BERTH_CAN_SETPOINT_RY_FRAME_ID, BERTH_CAN_SETPOINT_RY_LENGTH, SETPOINT_STATES},
    [SIDE_AXIS_RZ] = {BERTH_CAN_SETPOINT_RZ_FRAME_ID, BERTH_CAN_SETPOINT_RZ_LENGTH, SETPOINT_STATES},
};
static const struct transmission_row status_row = {BERTH_CAN_LOOP_STATUS_FRAME_ID, BERTH_CAN_LOOP_STATUS_LENGTH,
                                                   ~0u};

void robot_channel_start(struct robot_channel *channel, const struct app_config *config)
{
    const int64_t period_ticks = NS_PER_S / STATUS_RATE_HZ / config_period_ns(config);
    *channel =
        (struct robot_channel){.profile = (enum robot_profile)config->robot_channel.profile,
                               .status_period_ticks = period_ticks > 0 ? period_ticks : 1,
                               .side_config = config->side_axes,
                               .setpoint_stale_after_ns = ns_from_ms(config->robot_channel.setpoint_stale_after_ms),
                               .period_ns = config_period_ns(config)};
    if (channel->profile == ROBOT_PROFILE_CIA402) {
        cia402_start(&channel->drive, config);
    }
    for (int i = 0; i < SIDE_AXIS_COUNT; i++) {
        channel->has_sides |= config->side_axes[i].enabled != 0;
    }
}

void robot_channel_restart(struct robot_channel *channel)
{
    if (channel->profile == ROBOT_PROFILE_CIA402) {
        cia402_restart(&channel->drive);
    }
}

void robot_channel_begin_tick(struct robot_channel *channel)
{
    channel->has_feedback = 0;
}

static int receive_feedback(struct robot_channel *channel, const struct hal_frame *frame, double *position,
                            struct setpoint_echo *echo)
{
    struct berth_can_robot_feedback_t raw;
    if (berth_can_robot_feedback_unpack(&raw, frame->data, frame->length) < 0 ||
        !berth_can_robot_feedback_position_m_is_in_range(raw.position_m)) {
        return 0;
    }
    *position = berth_can_robot_feedback_position_m_decode(raw.position_m);
    setpoint_echo_report(echo, raw.setpoint_counter);
    channel->fault = raw.fault || (channel->has_feedback && channel->fault);
    channel->has_feedback = 1;
    return 1;
}

int robot_channel_receive(struct robot_channel *channel, enum received_message message,
                          const struct hal_frame *frame)
{
    const int axis = (int)message - RECEIVED_SIDE_FEEDBACK;
    if (axis >= 0 && axis < SIDE_AXIS_COUNT) {
        return receive_feedback(channel, frame, &channel->side_position[axis], &channel->side_echo[axis]);
    }
    if (channel->profile == ROBOT_PROFILE_BERTH) {
        return receive_feedback(channel, frame, &channel->position_m, &channel->echo);
    }
    const int is_taken = cia402_receive(&channel->drive, message, frame);
    channel->position_m = channel->drive.position_m;
    return is_taken;
}

/* Every axis has to be heard of. */
static int feedback_is_fresh(const struct robot_channel *channel, const struct reception *reception, int64_t now_ns)
{
    int is_fresh = !reception_is_stale(reception, RECEIVED_ROBOT_FEEDBACK, now_ns);
    for (int i = 0; channel->has_sides && i < SIDE_AXIS_COUNT; i++) {
        const enum received_message message = (enum received_message)(RECEIVED_SIDE_FEEDBACK + i);
        is_fresh &= !channel->side_config[i].enabled || !reception_is_stale(reception, message, now_ns);
    }
    return is_fresh;
}

static void judge_echo(struct robot_channel *channel, struct setpoint_echo *echo, uint8_t next_counter,
                       int64_t now_ns)
{
    const struct setpoint_stamp newest = {(uint8_t)(next_counter - 1), channel->setpoint_ns};
    if (channel->sends_setpoints) {
        setpoint_echo_step(echo, newest, channel->period_ns, channel->setpoint_stale_after_ns);
    } else {
        setpoint_echo_rest(echo, now_ns);
    }
    channel->setpoint_is_stale |= echo->is_stale;
    channel->follows &= echo->is_seen;
}

/* Every axis has to take its setpoints, and to say so. */
static void judge_echoes(struct robot_channel *channel, int64_t now_ns)
{
    channel->setpoint_is_stale = 0;
    channel->follows = 1;
    if (channel->setpoint_stale_after_ns == INT64_MAX) {
        return;
    }
    judge_echo(channel, &channel->echo, channel->setpoint_counter, now_ns);
    for (int i = 0; channel->has_sides && i < SIDE_AXIS_COUNT; i++) {
        if (channel->side_config[i].enabled) {
            judge_echo(channel, &channel->side_echo[i], channel->side_counter[i], now_ns);
        }
    }
}

void robot_channel_end_receive(struct robot_channel *channel, const struct reception *reception, int64_t now_ns)
{
    if (channel->profile == ROBOT_PROFILE_BERTH) {
        channel->is_fresh = (uint8_t)feedback_is_fresh(channel, reception, now_ns);
        judge_echoes(channel, now_ns);
        return;
    }
    struct cia402 *drive = &channel->drive;
    cia402_judge(drive, reception_is_stale(reception, RECEIVED_DRIVE_HEARTBEAT, now_ns));
    channel->fault = drive->trouble != DRIVE_TROUBLE_NONE;
    channel->is_fresh = cia402_is_ready(drive) && !reception_is_stale(reception, RECEIVED_DRIVE_STATUS, now_ns);
    channel->follows = (uint8_t)cia402_follows(drive);
}

/* Returns what the frame carries. */
static double send_setpoint(struct robot_channel *channel, const struct transmission_row *row, uint8_t *counter,
                            const struct supervisor *supervisor, const struct hal_tick *tick, double position,
                            struct tick_output *out)
{
    bool saturated = false;
    const double sent = codec_saturate(position, CAN_POSITION_MAX_m, &saturated);
    const double step_m = berth_can_setpoint_position_m_decode(1);
    const struct berth_can_setpoint_t raw = {
        .position_m = berth_can_setpoint_position_m_encode(codec_round(sent, step_m)),
        .motion_allowed = (uint8_t)supervisor_may_move(supervisor),
        .counter = *counter,
    };
    uint8_t data[8];
    if (berth_can_setpoint_pack(data, &raw, sizeof data) == (int)sizeof data &&
        transmit(out, row, 0, supervisor, tick, data)) {
        *counter += 1;
        channel->saturated_setpoints += saturated;
    }
    return berth_can_setpoint_position_m_decode(raw.position_m);
}

static void send_side_setpoints(struct robot_channel *channel, const struct supervisor *supervisor,
                                const struct hal_tick *tick, const double side[SIDE_AXIS_COUNT],
                                struct tick_output *out)
{
    for (int i = 0; i < SIDE_AXIS_COUNT; i++) {
        if (channel->side_config[i].enabled) {
            channel->side_sent[i] =
                send_setpoint(channel, &side_rows[i], &channel->side_counter[i], supervisor, tick, side[i], out);
        }
    }
}

/* A count that stays at the end of its 16 bits. */
static uint16_t at_most_16_bits(uint32_t count)
{
    return count < UINT16_MAX ? (uint16_t)count : UINT16_MAX;
}

static void send_status(struct robot_channel *channel, const struct supervisor *supervisor,
                        const struct hal_tick *tick, const struct robot_command *command, struct tick_output *out)
{
    const struct berth_can_loop_status_t raw = {
        .state = (uint8_t)supervisor->state,
        .stop_cause = (uint8_t)supervisor->stop_cause,
        .limits = (uint8_t)command->limits,
        .missed_ticks = at_most_16_bits(command->missed_ticks),
        .torn_samples = at_most_16_bits(command->torn_samples),
        .counter = channel->status_counter,
    };
    uint8_t data[8];
    if (berth_can_loop_status_pack(data, &raw, sizeof data) == (int)sizeof data) {
        channel->status_counter += (uint8_t)transmit(out, &status_row, 0, supervisor, tick, data);
    }
}

double robot_channel_send(struct robot_channel *channel, const struct supervisor *supervisor,
                          const struct hal_tick *tick, const struct robot_command *command, struct tick_output *out)
{
    double sent_position_m;
    if (channel->profile == ROBOT_PROFILE_BERTH) {
        channel->sends_setpoints = (SETPOINT_STATES & STATE_BIT(supervisor->state)) != 0;
        channel->setpoint_ns = tick->scheduled_ns;
        sent_position_m = send_setpoint(channel, &setpoint_row, &channel->setpoint_counter, supervisor, tick,
                                        command->position_m, out);
        if (channel->has_sides) {
            send_side_setpoints(channel, supervisor, tick, command->side, out);
        }
    } else {
        channel->drive.setup.may_move = (uint8_t)command->enable_is_on;
        sent_position_m =
            cia402_send(&channel->drive, supervisor, tick, command->position_m, command->reset_is_wanted, out);
        channel->saturated_setpoints = channel->drive.saturated_setpoints;
    }
    if (tick->index % channel->status_period_ticks == 0) {
        send_status(channel, supervisor, tick, command, out);
    }
    return sent_position_m;
}
