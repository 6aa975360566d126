#include "reception.h"

#include <string.h>

#include "can/berth_can.h"

struct reception_row {
    uint32_t id;
    uint8_t bus;
    uint8_t length;
    uint8_t counter_byte;
    uint8_t counter_shift;
    uint8_t counter_mask; /* the counter runs from 0 to this and starts again */
    uint8_t per_tick;     /* frames that belong to one period */
    size_t stale_after;   /* place of the age in ms in struct app_config */
    /* The ranges of the signals are checked where they are decoded, in the channel. */
};

#define AGE_OF(member) offsetof(struct app_config, member.stale_after_ms)

/* clang-format off */
static const struct reception_row rows[] = {
    /*                            identifier                          bus          length  counter    per tick  age */
    [RECEIVED_ROBOT_FEEDBACK]  = {BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID,  HAL_BUS_ROBOT,  8, 7, 0, 0xff, 1, AGE_OF(robot_channel)},
    [RECEIVED_OPERATOR_MOTION] = {BERTH_CAN_OPERATOR_MOTION_FRAME_ID, HAL_BUS_ROBOT,  8, 7, 4, 0x0f, 1, AGE_OF(operator_command)},
    [RECEIVED_OPERATOR_FORCE]  = {BERTH_CAN_OPERATOR_FORCE_FRAME_ID,  HAL_BUS_ROBOT,  8, 7, 4, 0x0f, 1, AGE_OF(operator_command)},
    [RECEIVED_FORCE]           = {BERTH_CAN_FORCE_FRAME_ID,           HAL_BUS_SENSOR, 8, 7, 0, 0xff, 1, AGE_OF(sensor_channel)},
};
/* clang-format on */
_Static_assert(sizeof rows / sizeof rows[0] == RECEIVED_COUNT, "one row per received message");

void reception_start(struct reception *reception, const struct app_config *config)
{
    *reception = (struct reception){0};
    for (int i = 0; i < RECEIVED_COUNT; i++) {
        double stale_after_ms;
        memcpy(&stale_after_ms, (const char *)config + rows[i].stale_after, sizeof stale_after_ms);
        reception->stale_after_ns[i] = ns_from_ms(stale_after_ms);
    }
}

void reception_begin_tick(struct reception *reception, uint32_t missed_ticks)
{
    reception->bus_off = 0;
    reception->periods_waited = missed_ticks + 1u;
    memset(reception->in_tick, 0, sizeof reception->in_tick);
}

static enum received_message row_of(const struct hal_frame *frame)
{
    for (int i = 0; i < RECEIVED_COUNT; i++) {
        if (rows[i].id == frame->id && rows[i].bus == frame->bus) {
            return (enum received_message)i;
        }
    }
    return RECEIVED_NONE;
}

static uint8_t counter_of(const struct reception_row *row, const struct hal_frame *frame)
{
    return (uint8_t)(frame->data[row->counter_byte] >> row->counter_shift) & row->counter_mask;
}

enum received_message reception_check(struct reception *reception, const struct hal_frame *frame)
{
    if (frame->flags & HAL_FRAME_ERROR) {
        reception->counts.error_frames++;
        reception->bus_off |= (frame->flags & HAL_FRAME_BUS_OFF) != 0;
        return RECEIVED_NONE;
    }
    enum received_message message = row_of(frame);
    if (message == RECEIVED_NONE) {
        reception->counts.unknown++;
        return RECEIVED_NONE;
    }
    const struct reception_row *row = &rows[message];
    if (frame->length != row->length) {
        reception->counts.wrong_length++;
        return RECEIVED_NONE;
    }
    if (reception->seen[message] && counter_of(row, frame) == reception->counter[message]) {
        reception->counts.repeated++;
        return RECEIVED_NONE;
    }
    return message;
}

void reception_accept(struct reception *reception, enum received_message message, const struct hal_frame *frame)
{
    const struct reception_row *row = &rows[message];
    uint8_t counter = counter_of(row, frame);
    if (reception->seen[message]) {
        uint8_t expected = (uint8_t)(reception->counter[message] + 1) & row->counter_mask;
        reception->counts.lost += (uint8_t)(counter - expected) & row->counter_mask;
    }
    reception->counter[message] = counter;
    reception->seen[message] = 1;
    reception->received_ns[message] = frame->time_ns;
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
