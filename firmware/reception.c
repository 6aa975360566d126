#include "reception.h"

#include "can/berth_can.h"

struct reception_row {
    uint32_t id;
    uint8_t bus;
    uint8_t length;
    uint8_t counter_byte;
    uint8_t counter_shift;
    uint8_t counter_mask; /* the counter runs from 0 to this and starts again */
};

static const struct reception_row rows[] = {
    [RECEIVED_ROBOT_FEEDBACK] = {BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID, HAL_BUS_ROBOT, 8, 7, 0, 0xff},
    [RECEIVED_OPERATOR_MOTION] = {BERTH_CAN_OPERATOR_MOTION_FRAME_ID, HAL_BUS_ROBOT, 8, 7, 4, 0x0f},
    [RECEIVED_OPERATOR_FORCE] = {BERTH_CAN_OPERATOR_FORCE_FRAME_ID, HAL_BUS_ROBOT, 8, 7, 4, 0x0f},
    [RECEIVED_FORCE] = {BERTH_CAN_FORCE_FRAME_ID, HAL_BUS_SENSOR, 8, 7, 0, 0xff},
};
_Static_assert(sizeof rows / sizeof rows[0] == RECEIVED_COUNT, "one row per received message");

void reception_start(struct reception *reception, const struct app_config *config)
{
    *reception = (struct reception){0};
    reception->stale_after_ns[RECEIVED_ROBOT_FEEDBACK] = ns_from_ms(config->robot_channel.stale_after_ms);
    reception->stale_after_ns[RECEIVED_OPERATOR_MOTION] = ns_from_ms(config->operator_command.stale_after_ms);
    reception->stale_after_ns[RECEIVED_OPERATOR_FORCE] = ns_from_ms(config->operator_command.stale_after_ms);
    reception->stale_after_ns[RECEIVED_FORCE] = ns_from_ms(config->sensor_channel.stale_after_ms);
}

void reception_begin_tick(struct reception *reception)
{
    reception->bus_off = 0;
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
