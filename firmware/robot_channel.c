#include "robot_channel.h"

#include "can/codec.h"
#include "transmission.h"

/* Ten status frames a second: enough for a person, 0.1 % of the bus. */
#define STATUS_RATE_HZ 10

/* The robot gets setpoints from the moment that its feedback is known to be near them. In fault they lead it to
 * rest and hold it there, with motion_allowed cleared. */
static const struct transmission_row setpoint_row = {BERTH_CAN_SETPOINT_FRAME_ID, BERTH_CAN_SETPOINT_LENGTH,
                                                     STATE_BIT(SUPERVISOR_READY) | STATE_BIT(SUPERVISOR_RUNNING) |
                                                         STATE_BIT(SUPERVISOR_HOLDING) |
                                                         STATE_BIT(SUPERVISOR_FAULT)};
static const struct transmission_row status_row = {BERTH_CAN_LOOP_STATUS_FRAME_ID, BERTH_CAN_LOOP_STATUS_LENGTH,
                                                   ~0u};

void robot_channel_start(struct robot_channel *channel, const struct app_config *config)
{
    const int64_t period_ticks = NS_PER_S / STATUS_RATE_HZ / config_period_ns(config);
    *channel = (struct robot_channel){.profile = (enum robot_profile)config->robot_channel.profile,
                                      .status_period_ticks = period_ticks > 0 ? period_ticks : 1};
    if (channel->profile == ROBOT_PROFILE_CIA402) {
        cia402_start(&channel->drive, config);
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

static int receive_feedback(struct robot_channel *channel, const struct hal_frame *frame)
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

int robot_channel_receive(struct robot_channel *channel, enum received_message message,
                          const struct hal_frame *frame)
{
    if (channel->profile == ROBOT_PROFILE_BERTH) {
        return receive_feedback(channel, frame);
    }
    const int is_taken = cia402_receive(&channel->drive, message, frame);
    channel->position_m = channel->drive.position_m;
    return is_taken;
}

void robot_channel_end_receive(struct robot_channel *channel, const struct reception *reception, int64_t now_ns)
{
    if (channel->profile == ROBOT_PROFILE_BERTH) {
        channel->is_fresh = !reception_is_stale(reception, RECEIVED_ROBOT_FEEDBACK, now_ns);
        channel->follows = 1;
        return;
    }
    struct cia402 *drive = &channel->drive;
    cia402_judge(drive, reception_is_stale(reception, RECEIVED_DRIVE_HEARTBEAT, now_ns));
    channel->fault = drive->trouble != DRIVE_TROUBLE_NONE;
    channel->is_fresh = cia402_is_ready(drive) && !reception_is_stale(reception, RECEIVED_DRIVE_STATUS, now_ns);
    channel->follows = (uint8_t)cia402_follows(drive);
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
        transmit(out, &setpoint_row, 0, supervisor, tick, data)) {
        channel->setpoint_counter++;
        channel->saturated_setpoints += saturated;
    }
    return berth_can_setpoint_position_m_decode(raw.position_m);
}

static void send_status(struct robot_channel *channel, const struct supervisor *supervisor,
                        const struct hal_tick *tick, const struct robot_command *command, struct tick_output *out)
{
    const struct berth_can_loop_status_t raw = {
        .state = (uint8_t)supervisor->state,
        .stop_cause = (uint8_t)supervisor->stop_cause,
        .limits = (uint8_t)command->limits,
        .missed_ticks = command->missed_ticks < UINT16_MAX ? (uint16_t)command->missed_ticks : UINT16_MAX,
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
        sent_position_m = send_setpoint(channel, supervisor, tick, command->position_m, out);
    } else {
        sent_position_m =
            cia402_send(&channel->drive, supervisor, tick, command->position_m, command->reset_is_wanted, out);
        channel->saturated_setpoints = channel->drive.saturated_setpoints;
    }
    if (tick->index % channel->status_period_ticks == 0) {
        send_status(channel, supervisor, tick, command, out);
    }
    return sent_position_m;
}
