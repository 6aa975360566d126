#include "reception.h"

#include <string.h>

#include "can/berth_can.h"
#include "canopen.h"

/* A message of the robot's bus; the sensor's come from its layout, and the operator's from the bus that is
 * configured. */
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

static int is_of_operator(int message)
{
    return message >= RECEIVED_OPERATOR_MOTION && message <= RECEIVED_OPERATOR_LINE;
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
    if (is_of_operator(message) && row.bus != HAL_BUS_COUNT) {
        row.bus = (uint8_t)config->operator_command.bus;
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

/* A counter tells old from new for half a turn, counted in the frames that belong to the time, and until a tick has
 * seen that its message is stale: then the sender may have begun anew. */
static int64_t counter_lasts_ns(const struct message_reception *of, int64_t period_ns)
{
    const int64_t half_turn_ns = of->row.counter_mask / 2 * period_ns / of->row.per_tick;
    const int64_t stale_ns = of->stale_after_ns + 2 * period_ns;
    return half_turn_ns < stale_ns ? half_turn_ns : stale_ns;
}

void reception_start(struct reception *reception, const struct app_config *config)
{
    *reception = (struct reception){.period_ns = config_period_ns(config)};
    memset(reception->message_of, RECEIVED_NONE, sizeof reception->message_of);
    for (int i = RECEIVED_COUNT - 1; i >= 0; i--) { /* of two with the same identifier, the first counts */
        struct message_reception *of = &reception->messages[i];
        of->row = row_for(config, i);
        of->stale_after_ns = ns_from_ms(stale_after_ms(config, i));
        if (of->row.bus != HAL_BUS_COUNT) {
            of->counter_lasts_ns = counter_lasts_ns(of, reception->period_ns);
            reception->message_of[of->row.bus][of->row.id] = (uint8_t)i;
        }
    }
}

void reception_begin_tick(struct reception *reception, uint32_t missed_ticks, int64_t now_ns)
{
    reception->now_ns = now_ns;
    reception->bus_off = 0;
    reception->periods_waited = missed_ticks + 1u;
    memset(reception->in_tick, 0, sizeof reception->in_tick);
}

static enum received_message message_of(const struct reception *reception, const struct hal_frame *frame)
{
    return frame->bus < HAL_BUS_COUNT && frame->id < CAN_IDS
               ? (enum received_message)reception->message_of[frame->bus][frame->id]
               : RECEIVED_NONE;
}

static uint8_t counter_of(const struct reception_row *row, const struct hal_frame *frame)
{
    return (uint8_t)(frame->data[row->counter_byte] >> row->counter_shift) & row->counter_mask;
}

/* By how many frames a counter is before the newest one, or as far ahead of it as is left of the turn. */
static uint8_t frames_behind(const struct message_reception *of, uint8_t counter)
{
    return (uint8_t)(of->counter - counter) & of->row.counter_mask;
}

/* Less than half a turn before the newest one; further away it is ahead, and many were lost. */
static int is_behind(const struct message_reception *of, uint8_t frames)
{
    return frames > 0 && frames <= of->row.counter_mask / 2;
}

/* A frame with a counter behind the newest one counts on from a refused frame at the sender's pace: not that one was
 * from the past, but the frame before it was not the sender's. Old frames that were held up come in a burst. */
static int goes_on_behind(const struct message_reception *of, int64_t time_ns, uint8_t counter, int64_t period_ns)
{
    const int64_t since_behind_ns = time_ns - of->behind.time_ns;
    return of->behind.seen && counter == ((of->behind.counter + 1) & of->row.counter_mask) &&
           2 * since_behind_ns * of->row.per_tick >= period_ns && since_behind_ns <= of->counter_lasts_ns;
}

/* From the past, by its stamp or by its counter. */
static int is_old(const struct message_reception *of, int64_t time_ns, int counter_is_behind, int64_t now_ns)
{
    const int64_t since_newest_ns = time_ns - of->received_ns;
    if (now_ns - time_ns > of->stale_after_ns) {
        return 1;
    }
    if (!of->seen || since_newest_ns < 0) {
        return of->seen;
    }
    return counter_is_behind && since_newest_ns <= of->counter_lasts_ns;
}

enum received_message reception_check(struct reception *reception, const struct hal_frame *frame)
{
    if (frame->flags & HAL_FRAME_ERROR) {
        reception->counts.error_frames++;
        reception->bus_off |= (frame->flags & HAL_FRAME_BUS_OFF) != 0;
        return RECEIVED_NONE;
    }
    const enum received_message message = message_of(reception, frame);
    if (message == RECEIVED_NONE) {
        reception->counts.unknown++;
        return RECEIVED_NONE;
    }
    struct message_reception *of = &reception->messages[message];
    if (frame->length != of->row.length) {
        reception->counts.wrong_length++;
        return RECEIVED_NONE;
    }
    const uint8_t counter = counter_of(&of->row, frame);
    const uint8_t behind = frames_behind(of, counter);
    int counter_is_behind = is_behind(of, behind);
    if (behind == 0 && of->seen && of->row.counter_mask != 0) {
        reception->counts.repeated++;
        return RECEIVED_NONE;
    }
    if (counter_is_behind && goes_on_behind(of, frame->time_ns, counter, reception->period_ns)) {
        of->counter = of->behind.counter;
        counter_is_behind = 0;
    }
    if (is_old(of, frame->time_ns, counter_is_behind, reception->now_ns)) {
        of->behind = (struct behind_frame){frame->time_ns, counter, 1};
        reception->counts.old++;
        return RECEIVED_NONE;
    }
    return message;
}

void reception_accept(struct reception *reception, enum received_message message, const struct hal_frame *frame)
{
    struct message_reception *of = &reception->messages[message];
    const uint8_t counter = counter_of(&of->row, frame);
    if (of->seen) {
        reception->counts.lost += (uint8_t)(counter - of->counter - 1) & of->row.counter_mask;
    }
    of->counter = counter;
    of->seen = 1;
    of->received_ns = frame->time_ns < reception->now_ns ? frame->time_ns : reception->now_ns;
    reception->counts.accepted++;
    /* A frame that the bus held up comes together with its successor: one more than belongs is no news. */
    if (++reception->in_tick[message] > of->row.per_tick * reception->periods_waited + 1u) {
        reception->counts.too_frequent++;
    }
}

void reception_reject_range(struct reception *reception)
{
    reception->counts.out_of_range++;
}

int reception_is_stale(const struct reception *reception, enum received_message message, int64_t now_ns)
{
    const struct message_reception *of = &reception->messages[message];
    return !of->seen || now_ns - of->received_ns > of->stale_after_ns;
}
