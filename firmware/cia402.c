#include "cia402.h"

#include <stddef.h>

#include "can/codec.h"
#include "canopen.h"
#include "transmission.h"

/* Bits of the controlword; what they ask for stands beside their sums. */
enum controlword {
    CONTROL_DISABLE_VOLTAGE = 0x0000,
    CONTROL_SHUTDOWN = 0x0006,
    CONTROL_SWITCH_ON = 0x0007,
    CONTROL_ENABLE_OPERATION = 0x000f,
    CONTROL_FAULT_RESET = 0x0080, /* with its rising edge; without voltage */
};

/* The statusword's bits that make a state, and the controlword that leads from there towards operation enabled. */
struct state_row {
    uint16_t mask;
    uint16_t bits;
    uint16_t towards_enabled;
};

static const struct state_row state_rows[] = {
    [DRIVE_NOT_READY_TO_SWITCH_ON] = {0x4f, 0x00, CONTROL_DISABLE_VOLTAGE},
    [DRIVE_SWITCH_ON_DISABLED] = {0x4f, 0x40, CONTROL_SHUTDOWN},
    [DRIVE_READY_TO_SWITCH_ON] = {0x6f, 0x21, CONTROL_SWITCH_ON},
    [DRIVE_SWITCHED_ON] = {0x6f, 0x23, CONTROL_ENABLE_OPERATION},
    [DRIVE_OPERATION_ENABLED] = {0x6f, 0x27, CONTROL_ENABLE_OPERATION},
    [DRIVE_QUICK_STOP_ACTIVE] = {0x6f, 0x07, CONTROL_DISABLE_VOLTAGE},
    [DRIVE_FAULT_REACTION_ACTIVE] = {0x4f, 0x0f, CONTROL_DISABLE_VOLTAGE},
    [DRIVE_FAULT] = {0x4f, 0x08, CONTROL_DISABLE_VOLTAGE},
    [DRIVE_UNKNOWN] = {0xffff, 0xffff, CONTROL_DISABLE_VOLTAGE},
};
_Static_assert(sizeof state_rows / sizeof state_rows[0] == DRIVE_STATE_COUNT + 1, "one row per state");

static const char *const state_names[] = {
    [DRIVE_NOT_READY_TO_SWITCH_ON] = "not ready to switch on",
    [DRIVE_SWITCH_ON_DISABLED] = "switch on disabled",
    [DRIVE_READY_TO_SWITCH_ON] = "ready to switch on",
    [DRIVE_SWITCHED_ON] = "switched on",
    [DRIVE_OPERATION_ENABLED] = "operation enabled",
    [DRIVE_QUICK_STOP_ACTIVE] = "quick stop active",
    [DRIVE_FAULT_REACTION_ACTIVE] = "fault reaction active",
    [DRIVE_FAULT] = "fault",
    [DRIVE_UNKNOWN] = "unknown",
};
_Static_assert(sizeof state_names / sizeof state_names[0] == DRIVE_STATE_COUNT + 1, "one name per state");

static const char *const trouble_names[] = {
    [DRIVE_TROUBLE_NONE] = "none",
    [DRIVE_TROUBLE_SDO_ABORT] = "the drive refuses an object",
    [DRIVE_TROUBLE_NO_ANSWER] = "the drive does not answer its set-up",
    [DRIVE_TROUBLE_WRONG_VALUE] = "an object of the drive is not what it has to be",
    [DRIVE_TROUBLE_EMERGENCY] = "the drive has sent an emergency message",
    [DRIVE_TROUBLE_HEARTBEAT] = "the drive's heartbeat is missing",
    [DRIVE_TROUBLE_NOT_OPERATIONAL] = "the drive has left the NMT state operational",
    [DRIVE_TROUBLE_FAULT] = "the drive is in fault",
    [DRIVE_TROUBLE_NOT_ENABLED] = "the drive does not reach operation enabled",
    [DRIVE_TROUBLE_DROPPED_OUT] = "the drive has left operation enabled by itself",
    [DRIVE_TROUBLE_STRANGE_ANSWER] = "the drive answers its set-up in a way that CiA 301 does not have",
    [DRIVE_TROUBLE_NO_PERIOD] = "the drive cannot take the loop's period",
    [DRIVE_TROUBLE_UNWATCHED] = "the drive would not stop when the loop dies: it cannot watch the loop's heartbeat",
    [DRIVE_TROUBLE_NO_PDO] =
        "the drive's PDO mapping is fixed, and none of its PDOs 1 to 4 carries what the loop needs",
    [DRIVE_TROUBLE_HOMING] = "the drive's homing has failed",
};
_Static_assert(sizeof trouble_names / sizeof trouble_names[0] == DRIVE_TROUBLE_COUNT, "one name per trouble");

#define ALIVE                                                                                                       \
    (STATE_BIT(SUPERVISOR_START) | STATE_BIT(SUPERVISOR_READY) | STATE_BIT(SUPERVISOR_RUNNING) |                    \
     STATE_BIT(SUPERVISOR_HOLDING) | STATE_BIT(SUPERVISOR_FAULT))

/* SYNC and setpoints go on in every state; in start and stopped they switch the drive off: it must be told so. */
static const struct transmission_row sync_row = {CANOPEN_SYNC_ID, 0, ~0u};
static const struct transmission_row setpoint_row = {CANOPEN_RPDO1_ID, 6, ~0u};
static const struct transmission_row heartbeat_row = {CANOPEN_HEARTBEAT_ID, 1, ALIVE};
static const struct transmission_row guard_row = {CANOPEN_HEARTBEAT_ID, 0, ALIVE};
static const struct transmission_row farewell_row = {CANOPEN_NMT_ID, 2, STATE_BIT(SUPERVISOR_STOPPED)};

/* In which states of the supervisor the drive is led to operation enabled, and kept there if it is. */
#define ENABLING_STATES (STATE_BIT(SUPERVISOR_READY) | STATE_BIT(SUPERVISOR_RUNNING) | STATE_BIT(SUPERVISOR_HOLDING))
#define KEEPING_STATES STATE_BIT(SUPERVISOR_FAULT)

void cia402_start(struct cia402 *drive, const struct app_config *config)
{
    const int64_t heartbeat_ticks = ns_from_ms(config->cia402.heartbeat_ms) / config_period_ns(config);
    const double tolerance_counts = config->robot_channel.start_tolerance_m * config->cia402.counts_per_m;
    const double step_counts = tolerance_counts * config_period_s(config);
    *drive = (struct cia402){.config = config,
                             .state = DRIVE_UNKNOWN,
                             .bridge_step_counts = step_counts < 1.0 ? 1 : (int64_t)step_counts,
                             .heartbeat_period_ticks = heartbeat_ticks < 1 ? 1u : (uint32_t)heartbeat_ticks};
    cia402_setup_start(&drive->setup, config);
}

static void forget_trouble(struct cia402 *drive)
{
    drive->trouble = DRIVE_TROUBLE_NONE;
    drive->error = 0;
    drive->error_code = 0;
    drive->enabling_ticks = 0;
    drive->was_enabled = 0;
}

void cia402_restart(struct cia402 *drive)
{
    cia402_setup_restart(&drive->setup);
    forget_trouble(drive);
}

enum cia402_state cia402_state_of(uint16_t statusword)
{
    for (int i = 0; i < DRIVE_STATE_COUNT; i++) {
        if ((statusword & state_rows[i].mask) == state_rows[i].bits) {
            return (enum cia402_state)i;
        }
    }
    return DRIVE_UNKNOWN;
}

static int receive_status(struct cia402 *drive, const uint8_t data[8])
{
    const int32_t counts = (int32_t)canopen_get(data + 2, 4);
    const double position_m = (double)counts / drive->config->cia402.counts_per_m;
    const uint16_t statusword = (uint16_t)canopen_get(data, 2);
    const enum cia402_state state = cia402_state_of(statusword);
    if (!(position_m >= -CAN_POSITION_MAX_m && position_m <= CAN_POSITION_MAX_m) || state == DRIVE_UNKNOWN) {
        return 0;
    }
    drive->position_m = position_m;
    drive->position_counts = counts;
    drive->statusword = statusword;
    drive->state = (uint8_t)state;
    return 1;
}

/* An answer to a poll whose bit has not changed is an old one, and counts as none. */
static int toggle_fits(struct cia402 *drive, uint8_t toggle)
{
    if (!drive->setup.is_guarding) {
        return toggle == 0;
    }
    if (toggle != drive->guard_toggle) {
        return 0;
    }
    drive->guard_toggle ^= CANOPEN_GUARD_TOGGLE;
    return 1;
}

/* A heartbeat, the answer to a poll, or a boot-up message. */
static int receive_heartbeat(struct cia402 *drive, uint8_t byte)
{
    const uint8_t nmt_state = byte & (uint8_t)~CANOPEN_GUARD_TOGGLE;
    if (byte == NMT_STATE_BOOT_UP) {
        cia402_setup_booted(&drive->setup);
        drive->state = DRIVE_UNKNOWN;
        drive->error_code = 0;
        drive->guard_toggle = 0;
    } else if ((nmt_state != NMT_STATE_STOPPED && nmt_state != NMT_STATE_OPERATIONAL &&
                nmt_state != NMT_STATE_PRE_OPERATIONAL) ||
               !toggle_fits(drive, byte & CANOPEN_GUARD_TOGGLE)) {
        return 0;
    }
    drive->nmt_state = nmt_state;
    return 1;
}

int cia402_receive(struct cia402 *drive, enum received_message message, const struct hal_frame *frame)
{
    switch (message) {
    case RECEIVED_DRIVE_STATUS:
        return receive_status(drive, frame->data);
    case RECEIVED_DRIVE_HEARTBEAT:
        return receive_heartbeat(drive, frame->data[0]);
    case RECEIVED_DRIVE_EMERGENCY:
        drive->error_code = (uint16_t)canopen_get(frame->data, 2);
        return 1;
    case RECEIVED_SDO_ANSWER:
        return cia402_setup_receive(&drive->setup, frame->data);
    default:
        return 0;
    }
}

static enum cia402_trouble setup_trouble(const struct cia402_setup *setup)
{
    switch ((enum cia402_setup_trouble)setup->trouble) {
    case SETUP_ABORTED:
        return DRIVE_TROUBLE_SDO_ABORT;
    case SETUP_NO_ANSWER:
        return DRIVE_TROUBLE_NO_ANSWER;
    case SETUP_WRONG_VALUE:
        return DRIVE_TROUBLE_WRONG_VALUE;
    case SETUP_STRANGE_ANSWER:
        return DRIVE_TROUBLE_STRANGE_ANSWER;
    case SETUP_NO_PERIOD:
        return DRIVE_TROUBLE_NO_PERIOD;
    case SETUP_UNWATCHED:
        return DRIVE_TROUBLE_UNWATCHED;
    case SETUP_NO_PDO:
        return DRIVE_TROUBLE_NO_PDO;
    case SETUP_HOMING:
        return DRIVE_TROUBLE_HOMING;
    case SETUP_FINE:
        break;
    }
    return DRIVE_TROUBLE_NONE;
}

/* Of a drive that has not been set up yet only the set-up's own trouble counts: what it was in before is not ours.
 */
static enum cia402_trouble trouble_of(const struct cia402 *drive, int heartbeat_is_stale)
{
    if (!cia402_setup_is_done(&drive->setup) || drive->setup.trouble != SETUP_FINE) {
        return setup_trouble(&drive->setup);
    }
    const int is_faulty = drive->state == DRIVE_FAULT || drive->state == DRIVE_FAULT_REACTION_ACTIVE;
    const struct {
        int holds;
        enum cia402_trouble trouble;
    } checks[] = {
        {drive->error_code != 0, DRIVE_TROUBLE_EMERGENCY},
        {is_faulty, DRIVE_TROUBLE_FAULT},
        {heartbeat_is_stale, DRIVE_TROUBLE_HEARTBEAT},
        {drive->nmt_state != NMT_STATE_OPERATIONAL, DRIVE_TROUBLE_NOT_OPERATIONAL},
        {drive->was_enabled && !cia402_is_enabled(drive), DRIVE_TROUBLE_DROPPED_OUT},
        {drive->enabling_ticks > drive->setup.state_timeout_ticks, DRIVE_TROUBLE_NOT_ENABLED},
    };
    for (size_t i = 0; i < sizeof checks / sizeof checks[0]; i++) {
        if (checks[i].holds) {
            return checks[i].trouble;
        }
    }
    return DRIVE_TROUBLE_NONE;
}

static uint32_t error_of(const struct cia402 *drive)
{
    switch ((enum cia402_trouble)drive->trouble) {
    case DRIVE_TROUBLE_NONE:
        return 0;
    case DRIVE_TROUBLE_SDO_ABORT:
        return drive->setup.abort_code;
    case DRIVE_TROUBLE_WRONG_VALUE:
        return drive->setup.answer_value;
    case DRIVE_TROUBLE_NO_PERIOD:
        return cia402_period_error(drive->setup.period_value, drive->setup.period_index);
    default:
        return drive->error_code;
    }
}

void cia402_judge(struct cia402 *drive, int heartbeat_is_stale)
{
    if (drive->trouble == DRIVE_TROUBLE_NONE) {
        drive->trouble = (uint8_t)trouble_of(drive, heartbeat_is_stale);
    }
    if (drive->error == 0) {
        drive->error = error_of(drive);
    }
    drive->was_enabled = drive->was_enabled || (cia402_setup_is_done(&drive->setup) && cia402_is_enabled(drive));
}

/* A person has asked for it: the trouble is forgotten, and a drive that has lost its set-up gets it again. */
static void reset(struct cia402 *drive)
{
    const int has_lost_setup = drive->trouble == DRIVE_TROUBLE_HEARTBEAT ||
                               drive->trouble == DRIVE_TROUBLE_NOT_OPERATIONAL || drive->setup.trouble != SETUP_FINE;
    const int may_have_lost_power = drive->trouble == DRIVE_TROUBLE_HEARTBEAT;
    forget_trouble(drive);
    if (may_have_lost_power) {
        cia402_setup_forget_home(&drive->setup);
    }
    if (has_lost_setup) {
        cia402_restart(drive);
    }
}

static uint16_t controlword(struct cia402 *drive, const struct supervisor *supervisor, int reset_is_wanted)
{
    const uint32_t state = STATE_BIT(supervisor->state);
    const int is_enabled = cia402_is_enabled(drive);
    if (state & ENABLING_STATES) {
        drive->enabling_ticks = is_enabled ? 0 : drive->enabling_ticks + 1;
        return state_rows[drive->state].towards_enabled;
    }
    if (state & KEEPING_STATES) {
        if (reset_is_wanted && drive->trouble != DRIVE_TROUBLE_NONE) {
            reset(drive);
            return CONTROL_FAULT_RESET;
        }
        return is_enabled ? CONTROL_ENABLE_OPERATION : CONTROL_DISABLE_VOLTAGE;
    }
    return CONTROL_DISABLE_VOLTAGE;
}

/* Position in counts, to the nearest; what does not fit is sent as the end of the range, and counted. */
static int32_t counts_of(struct cia402 *drive, double position_m, int may_count)
{
    bool saturated = false;
    const double counts =
        codec_saturate(position_m * drive->config->cia402.counts_per_m, (double)INT32_MAX, &saturated);
    drive->saturated_setpoints += saturated && may_count;
    return (int32_t)(int64_t)codec_round(counts, saturated ? 0.0 : 1.0);
}

/* A drive without torque is sent its own position, so that nothing jumps when it is enabled. In ready it is led to
 * the loop's setpoint, over robot_channel.start_tolerance_m in a second. */
static void bridge(struct cia402 *drive, const struct supervisor *supervisor, int32_t command_counts)
{
    const int64_t step = drive->bridge_step_counts;
    if (!cia402_is_enabled(drive)) {
        drive->bridge_counts = drive->state == DRIVE_UNKNOWN ? 0 : (int64_t)drive->position_counts - command_counts;
    } else if (supervisor->state != SUPERVISOR_READY) {
        return;
    } else if (drive->bridge_counts > step) {
        drive->bridge_counts -= step;
    } else if (drive->bridge_counts < -step) {
        drive->bridge_counts += step;
    } else {
        drive->bridge_counts = 0;
    }
}

/* The set-up's frames of this tick. */
static void send_setup(struct cia402 *drive, const struct supervisor *supervisor, const struct hal_tick *tick,
                       struct tick_output *out)
{
    const int is_off = !cia402_is_enabled(drive) && drive->state != DRIVE_QUICK_STOP_ACTIVE;
    const int is_late = supervisor->state == SUPERVISOR_READY && cia402_setup_is_done(&drive->setup) && !is_off;
    if (supervisor->state == SUPERVISOR_START || is_late) {
        cia402_setup_step(&drive->setup, supervisor, tick, drive->nmt_state, is_off, out);
    } else {
        cia402_setup_hold(&drive->setup, supervisor, tick, out);
    }
}

/* Sends our heartbeat. A drive that sends none is polled. */
static void send_heartbeat(const struct cia402 *drive, const struct supervisor *supervisor,
                           const struct hal_tick *tick, struct tick_output *out)
{
    const struct cia402_config *config = &drive->config->cia402;
    const uint8_t heartbeat[8] = {NMT_STATE_OPERATIONAL};
    if (tick->index % drive->heartbeat_period_ticks != 0) {
        return;
    }
    transmit(out, &heartbeat_row, (uint32_t)config->master_node_id, supervisor, tick, heartbeat);
    if (drive->setup.is_guarding &&
        transmit(out, &guard_row, (uint32_t)config->node_id, supervisor, tick, (const uint8_t[8]){0})) {
        out->frames[out->frame_count - 1].flags = HAL_FRAME_REMOTE;
    }
}

double cia402_send(struct cia402 *drive, const struct supervisor *supervisor, const struct hal_tick *tick,
                   double command_position_m, int reset_is_wanted, struct tick_output *out)
{
    const struct cia402_config *config = &drive->config->cia402;
    const int is_last = supervisor->state == SUPERVISOR_STOPPED;
    const uint8_t nothing[8] = {0};
    const uint8_t farewell[8] = {NMT_COMMAND_RESET_COMMUNICATION, (uint8_t)config->node_id};
    const int32_t command_counts = counts_of(drive, command_position_m, cia402_follows(drive));
    bridge(drive, supervisor, command_counts);
    const int32_t counts = (int32_t)(command_counts + drive->bridge_counts);
    uint8_t setpoint[8] = {0};
    canopen_put(setpoint, controlword(drive, supervisor, reset_is_wanted), 2);
    canopen_put(setpoint + 2, (uint32_t)counts, 4);

    if (!is_last) {
        transmit(out, &sync_row, 0, supervisor, tick, nothing);
    }
    transmit(out, &setpoint_row, (uint32_t)config->node_id, supervisor, tick, setpoint);
    if (is_last) { /* no tick follows whose SYNC could switch the drive off */
        transmit(out, &sync_row, 0, supervisor, tick, nothing);
    }
    send_setup(drive, supervisor, tick, out);
    transmit(out, &farewell_row, 0, supervisor, tick, farewell);
    send_heartbeat(drive, supervisor, tick, out);
    return (double)counts / config->counts_per_m;
}

const char *cia402_state_name(enum cia402_state state)
{
    return (unsigned)state <= DRIVE_STATE_COUNT ? state_names[state] : "unknown";
}

const char *cia402_trouble_name(enum cia402_trouble trouble)
{
    return (unsigned)trouble < DRIVE_TROUBLE_COUNT ? trouble_names[trouble] : "unknown";
}
