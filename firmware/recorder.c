#include "recorder.h"

#include <stddef.h>
#include <string.h>

#define FORMAT_FIELD(type, name) #type " " #name ";"
const char *const tick_record_format = "tick:" TICK_RECORD_FIELDS(FORMAT_FIELD);
const char *const arm_record_format = "arm:" ARM_RECORD_FIELDS(FORMAT_FIELD);
const char *const side_record_format = "side:" SIDE_RECORD_FIELDS(FORMAT_FIELD);
const char *const frame_record_format = "can_frame:" FRAME_RECORD_FIELDS(FORMAT_FIELD);

#define FIELD_SIZE(type, name) +sizeof(type)
_Static_assert(sizeof(struct tick_record) == 0 TICK_RECORD_FIELDS(FIELD_SIZE), "the tick record has no padding");
_Static_assert(sizeof(struct arm_record) == 0 ARM_RECORD_FIELDS(FIELD_SIZE), "the arm record has no padding");
_Static_assert(sizeof(struct side_record) == 0 SIDE_RECORD_FIELDS(FIELD_SIZE), "the side record has no padding");
_Static_assert(sizeof(struct frame_record) == 0 FRAME_RECORD_FIELDS(FIELD_SIZE), "the frame record has no padding");
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "ULog is little-endian, records are copied as they are");

_Static_assert(offsetof(struct recorder, tick) == sizeof(((struct recorder *)0)->before),
               "the tick's record follows what is before it");

/* Starts a message and returns where its record goes. */
static uint8_t *begin_message(uint8_t *to, uint16_t message_id, uint16_t record_bytes)
{
    const uint16_t size_bytes = (uint16_t)(sizeof message_id + record_bytes);
    memcpy(to, &size_bytes, sizeof size_bytes);
    to[2] = 'D';
    memcpy(to + 3, &message_id, sizeof message_id);
    return to + ULOG_DATA_HEADER_BYTES;
}

/* Field by field: a copy of a whole record that has just been written waits until its fields have left the
 * processor's store queue. */
#define PUT_FIELD(type, name)                                                                                       \
    memcpy(to, &record->name, sizeof record->name);                                                                 \
    to += sizeof record->name;

static uint8_t *put_frame(uint8_t *to, const struct frame_record *record)
{
    to = begin_message(to, ULOG_FRAME_ID, sizeof *record);
    FRAME_RECORD_FIELDS(PUT_FIELD)
    return to;
}

static uint8_t *put_arm(uint8_t *to, const struct arm_record *record)
{
    to = begin_message(to, ULOG_ARM_ID, sizeof *record);
    ARM_RECORD_FIELDS(PUT_FIELD)
    return to;
}

static uint8_t *put_side(uint8_t *to, const struct side_record *record)
{
    to = begin_message(to, ULOG_SIDE_ID, sizeof *record);
    SIDE_RECORD_FIELDS(PUT_FIELD)
    return to;
}

static uint8_t *put_frames(uint8_t *to, const struct hal_frame *frames, uint32_t count, uint64_t timestamp,
                           uint8_t direction)
{
    for (uint32_t i = 0; i < count; i++) {
        const struct hal_frame *frame = &frames[i];
        struct frame_record record = {
            .timestamp = timestamp,
            .time_ns = frame->time_ns,
            .id = frame->id,
            .bus = frame->bus,
            .length = frame->length,
            .flags = frame->flags,
            .direction = direction,
        };
        memcpy(&record.data, frame->data, sizeof frame->data);
        to = put_frame(to, &record);
    }
    return to;
}

#define MESSAGE_BYTES(record) (ULOG_DATA_HEADER_BYTES + (uint32_t)sizeof(struct record))

void recorder_write(struct recorder *recorder, const struct tick_input *in, const struct tick_output *out,
                    const struct arm_record *arm, const struct side_record *side)
{
    const uint32_t before_bytes = (in->frame_count + out->frame_count) * MESSAGE_BYTES(frame_record) +
                                  (arm != NULL ? MESSAGE_BYTES(arm_record) : 0u) +
                                  (side != NULL ? MESSAGE_BYTES(side_record) : 0u) + ULOG_DATA_HEADER_BYTES;
    uint8_t *to = recorder->before + sizeof recorder->before - before_bytes;
    recorder->bytes = to;
    recorder->size_bytes = before_bytes + (uint32_t)sizeof recorder->tick;
    to = put_frames(to, in->frames, in->frame_count, recorder->tick.timestamp, 0);
    to = put_frames(to, out->frames, out->frame_count, recorder->tick.timestamp, 1);
    if (arm != NULL) {
        to = put_arm(to, arm);
    }
    if (side != NULL) {
        to = put_side(to, side);
    }
    begin_message(to, ULOG_TICK_ID, sizeof recorder->tick);
}
