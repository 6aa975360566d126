#include "reception.h"

#include <string.h>

#include "can/berth_can.h"
#include "canopen.h"

/* A message of the robot's bus; the sensor's come from its layout. */
struct message_row {
    uint8_t profiles;         /* of the robot channel that have this message, one bit each; and ARM */
    struct reception_row row; /* of a drive: its number is added to the identifier */
    size_t stale_after;       /* place of the age in ms in struct app_config */
};

#define BERTH (1u << ROBOT_PROFILE_BERTH)
#define CIA402 (1u << ROBOT_PROFILE_CIA402)
#define EVERY (BERTH | CIA402)
#define ARM (1u << ROBOT_PROFILE_COUNT) /* only with an arm */
#define AGE_OF(member) offsetof(struct app_config, member.stale_after_ms)

#define SIDE_FEEDBACK(axis, id)                                                                                     \
    [RECEIVED_SIDE_FEEDBACK + (axis)] = {BERTH | ARM, {id, HAL_BUS_ROBOT, 8, 7, 0, 0xff, 1}, AGE_OF(robot_channel)}

/* clang-format off */
static const struct message_row message_rows[RECEIVED_FORCE] = {
    /*                            profile  identifier                           bus           length  counter    per tick  age */
    [RECEIVED_ROBOT_FEEDBACK]  = {BERTH,  {BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID,  HAL_BUS_ROBOT,  8, 7, 0, 0xff, 1}, AGE_OF(robot_channel)},
    [RECEIVED_DRIVE_STATUS]    = {CIA402, {CANOPEN_TPDO1_ID,                   HAL_BUS_ROBOT,  6, 0, 0, 0,    1}, AGE_OF(robot_channel)},
    [RECEIVED_DRIVE_HEARTBEAT] = {CIA402, {CANOPEN_HEARTBEAT_ID,               HAL_BUS_ROBOT,  1, 0, 0, 0,    1}, AGE_OF(cia402)},
    [RECEIVED_DRIVE_EMERGENCY] = {CIA402, {CANOPEN_EMERGENCY_ID,               HAL_BUS_ROBOT,  8, 0, 0, 0,    1}, AGE_OF(cia402)},
    [RECEIVED_SDO_ANSWER]      = {CIA402, {CANOPEN_SDO_ANSWER_ID,              HAL_BUS_ROBOT,  8, 0, 0, 0,    1}, AGE_OF(cia402)},
    [RECEIVED_OPERATOR_MOTION] = {EVERY,  {BERTH_CAN_OPERATOR_MOTION_FRAME_ID, HAL_BUS_ROBOT,  8, 7, 4, 0x0f, 1}, AGE_OF(operator_command)},
    [RECEIVED_OPERATOR_FORCE]  = {EVERY,  {BERTH_CAN_OPERATOR_FORCE_FRAME_ID,  HAL_BUS_ROBOT,  8, 7, 4, 0x0f, 1}, AGE_OF(operator_command)},
    [RECEIVED_OPERATOR_JOINT]  = {EVERY | ARM, {BERTH_CAN_OPERATOR_JOINT_FRAME_ID, HAL_BUS_ROBOT, 8, 7, 4, 0x0f, ARM_JOINTS_MAX}, AGE_OF(operator_command)},
    [RECEIVED_OPERATOR_LINE]   = {EVERY | ARM, {BERTH_CAN_OPERATOR_LINE_FRAME_ID,  HAL_BUS_ROBOT, 8, 7, 4, 0x0f, 1}, AGE_OF(operator_command)},
    SIDE_FEEDBACK(SIDE_AXIS_Y,  BERTH_CAN_FEEDBACK_Y_FRAME_ID),
    SIDE_FEEDBACK(SIDE_AXIS_Z,  BERTH_CAN_FEEDBACK_Z_FRAME_ID),
    SIDE_FEEDBACK(SIDE_AXIS_RX, BERTH_CAN_FEEDBACK_RX_FRAME_ID),
    SIDE_FEEDBACK(SIDE_AXIS_RY, BERTH_CAN_FEEDBACK_RY_FRAME_ID),
    SIDE_FEEDBACK(SIDE_AXIS_RZ, BERTH_CAN_FEEDBACK_RZ_FRAME_ID),
};
/* clang-format on */

/* Frames of the sensor's layout; per tick as many as its rate makes, rounded up. */
static struct reception_row sensor_row(const struct app_config *config, int part)
{
    const struct sensor_layout_row *layout = &sensor_layouts[config->sensor_channel.layout];
    const struct sensor_frame *frame = &layout->frames[part];
    const int64_t sample_ns = config_sample_period_ns(config);
    if (part >= layout->frame_count) {
        return (struct reception_row){.bus = HAL_BUS_COUNT};
    }
    return (struct reception_row){.id = frame->id,
                                  .bus = HAL_BUS_SENSOR,
                                  .length = 8,
                                  .counter_byte = frame->counter_byte,
                                  .counter_mask = frame->counter_mask,
                                  .per_tick = (uint32_t)((config_period_ns(config) + sample_ns - 1) / sample_ns)};
}

static struct reception_row row_for(const struct app_config *config, int message)
{
    if (message >= RECEIVED_FORCE) {
        return sensor_row(config, message - RECEIVED_FORCE);
    }
    const struct message_row *entry = &message_rows[message];
    struct reception_row row = entry->row;
    const int needs_arm = (entry->profiles & ARM) != 0;
    const int axis = message - RECEIVED_SIDE_FEEDBACK;
    const int is_absent = axis >= 0 && axis < SIDE_AXIS_COUNT && !config->side_axes[axis].enabled;
    if (is_absent || !(entry->profiles & (1u << config->robot_channel.profile)) ||
        (needs_arm && config->arm.kind == ARM_NONE)) {
        row.bus = HAL_BUS_COUNT;
    }
    if (entry->profiles == CIA402) {
        row.id += (uint32_t)config->cia402.node_id;
    }
    return row;
}

static double stale_after_ms(const struct app_config *config, int message)
{
    const size_t place = message < RECEIVED_FORCE ? message_rows[message].stale_after : AGE_OF(sensor_channel);
    double age_ms;
    memcpy(&age_ms, (const char *)config + place, sizeof age_ms);
    return age_ms;
}

uint32_t reception_ids(const struct app_config *config, enum hal_bus bus, uint32_t ids[RECEIVED_COUNT])
{
    uint32_t count = 0;
    for (int i = 0; i < RECEIVED_COUNT; i++) {
        const struct reception_row row = row_for(config, i);
        if (row.bus == bus) {
            ids[count++] = row.id;
        }
    }
    return count;
}

void reception_start(struct reception *reception, const struct app_config *config)
{
    *reception = (struct reception){.period_ns = config_period_ns(config)};
    for (int i = 0; i < RECEIVED_COUNT; i++) {
        reception->rows[i] = row_for(config, i);
        if (reception->rows[i].bus != HAL_BUS_COUNT) {
            reception->heard[reception->heard_count++] = (uint8_t)i;
        }
        reception->stale_after_ns[i] = ns_from_ms(stale_after_ms(config, i));
    }
}

void reception_begin_tick(struct reception *reception, uint32_t missed_ticks, int64_t now_ns)
{
    reception->now_ns = now_ns;
    reception->bus_off = 0;
    reception->periods_waited = missed_ticks + 1u;
    memset(reception->in_tick, 0, sizeof reception->in_tick);
}

static enum received_message row_of(const struct reception *reception, const struct hal_frame *frame)
{
    for (uint32_t i = 0; i < reception->heard_count; i++) {
        const enum received_message message = (enum received_message)reception->heard[i];
        const struct reception_row *row = &reception->rows[message];
        if (row->id == frame->id && row->bus == frame->bus) {
            return message;
        }
    }
    return RECEIVED_NONE;
}

static uint8_t counter_of(const struct reception_row *row, const struct hal_frame *frame)
{
    return (uint8_t)(frame->data[row->counter_byte] >> row->counter_shift) & row->counter_mask;
}

/* Less than half a turn before the newest one; further away it is ahead, and many were lost. */
static int counter_is_behind(const struct reception_row *row, uint8_t newest, uint8_t counter)
{
    const uint8_t behind = (uint8_t)(newest - counter) & row->counter_mask;
    return behind > 0 && behind <= row->counter_mask / 2;
}

/* A counter tells old from new for half a turn, counted in the frames that belong to the time, and until a tick has
 * seen that its message is stale: then the sender may have begun anew. */
static int64_t counter_lasts_ns(const struct reception *reception, enum received_message message)
{
    const struct reception_row *row = &reception->rows[message];
    const int64_t half_turn_ns = row->counter_mask / 2 * reception->period_ns / row->per_tick;
    const int64_t stale_ns = reception->stale_after_ns[message] + 2 * reception->period_ns;
    return half_turn_ns < stale_ns ? half_turn_ns : stale_ns;
}

/* It counts on from a refused frame at the sender's pace: not that one was from the past, but the frame before it
 * was not the sender's. Old frames that were held up come in a burst. */
static int goes_on_behind(const struct reception *reception, enum received_message message,
                          const struct hal_frame *frame)
{
    const struct reception_row *row = &reception->rows[message];
    const struct behind_frame *behind = &reception->behind[message];
    const int64_t since_behind_ns = frame->time_ns - behind->time_ns;
    return behind->seen && counter_of(row, frame) == ((behind->counter + 1) & row->counter_mask) &&
           counter_is_behind(row, reception->counter[message], counter_of(row, frame)) &&
           2 * since_behind_ns * row->per_tick >= reception->period_ns &&
           since_behind_ns <= counter_lasts_ns(reception, message);
}

static int is_old(const struct reception *reception, enum received_message message, const struct hal_frame *frame)
{
    const int64_t since_newest_ns = frame->time_ns - reception->received_ns[message];
    const struct reception_row *row = &reception->rows[message];
    if (reception->now_ns - frame->time_ns > reception->stale_after_ns[message]) {
        return 1;
    }
    if (!reception->seen[message] || since_newest_ns < 0) {
        return reception->seen[message];
    }
    return counter_is_behind(row, reception->counter[message], counter_of(row, frame)) &&
           since_newest_ns <= counter_lasts_ns(reception, message);
}

enum received_message reception_check(struct reception *reception, const struct hal_frame *frame)
{
    if (frame->flags & HAL_FRAME_ERROR) {
        reception->counts.error_frames++;
        reception->bus_off |= (frame->flags & HAL_FRAME_BUS_OFF) != 0;
        return RECEIVED_NONE;
    }
    enum received_message message = row_of(reception, frame);
    if (message == RECEIVED_NONE) {
        reception->counts.unknown++;
        return RECEIVED_NONE;
    }
    const struct reception_row *row = &reception->rows[message];
    if (frame->length != row->length) {
        reception->counts.wrong_length++;
        return RECEIVED_NONE;
    }
    if (row->counter_mask != 0 && reception->seen[message] &&
        counter_of(row, frame) == reception->counter[message]) {
        reception->counts.repeated++;
        return RECEIVED_NONE;
    }
    if (goes_on_behind(reception, message, frame)) {
        reception->counter[message] = reception->behind[message].counter;
    }
    if (is_old(reception, message, frame)) {
        reception->behind[message] = (struct behind_frame){frame->time_ns, counter_of(row, frame), 1};
        reception->counts.old++;
        return RECEIVED_NONE;
    }
    return message;
}

void reception_accept(struct reception *reception, enum received_message message, const struct hal_frame *frame)
{
    const struct reception_row *row = &reception->rows[message];
    uint8_t counter = counter_of(row, frame);
    if (row->counter_mask != 0 && reception->seen[message]) {
        uint8_t expected = (uint8_t)(reception->counter[message] + 1) & row->counter_mask;
        reception->counts.lost += (uint8_t)(counter - expected) & row->counter_mask;
    }
    reception->counter[message] = counter;
    reception->seen[message] = 1;
    reception->received_ns[message] = frame->time_ns < reception->now_ns ? frame->time_ns : reception->now_ns;
    reception->counts.accepted++;
    /* A frame that the bus held up comes together with its successor: one more than belongs is no news. */
    if (++reception->in_tick[message] > row->per_tick * reception->periods_waited + 1u) {
        reception->counts.too_frequent++;
    }
}

void reception_reject_range(struct reception *reception)
{
    reception->counts.out_of_range++;
}

int reception_is_stale(const struct reception *reception, enum received_message message, int64_t now_ns)
{
    return !reception->seen[message] ||
           now_ns - reception->received_ns[message] > reception->stale_after_ns[message];
}
