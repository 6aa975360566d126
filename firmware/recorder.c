#include "recorder.h"

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

/* Starts a message and returns where its record goes. */
static uint8_t *begin_message(struct recorder *recorder, uint16_t message_id, uint16_t record_bytes)
{
    uint8_t *to = recorder->bytes + recorder->size_bytes;
    const uint16_t size_bytes = (uint16_t)(sizeof message_id + record_bytes);
    memcpy(to, &size_bytes, sizeof size_bytes);
    to[2] = 'D';
    memcpy(to + 3, &message_id, sizeof message_id);
    recorder->size_bytes += ULOG_DATA_HEADER_BYTES + record_bytes;
    return to + ULOG_DATA_HEADER_BYTES;
}

/* Field by field: a copy of a whole record that has just been written waits until its fields have left the
 * processor's store queue. */
#define PUT_FIELD(type, name)                                                                                       \
    memcpy(to, &record->name, sizeof record->name);                                                                 \
    to += sizeof record->name;

static void append_frame(struct recorder *recorder, const struct frame_record *record)
{
    uint8_t *to = begin_message(recorder, ULOG_FRAME_ID, sizeof *record);
    FRAME_RECORD_FIELDS(PUT_FIELD)
}

static void append_tick(struct recorder *recorder, const struct tick_record *record)
{
    uint8_t *to = begin_message(recorder, ULOG_TICK_ID, sizeof *record);
    TICK_RECORD_FIELDS(PUT_FIELD)
}

static void append_arm(struct recorder *recorder, const struct arm_record *record)
{
    uint8_t *to = begin_message(recorder, ULOG_ARM_ID, sizeof *record);
    ARM_RECORD_FIELDS(PUT_FIELD)
}

static void append_side(struct recorder *recorder, const struct side_record *record)
{
    uint8_t *to = begin_message(recorder, ULOG_SIDE_ID, sizeof *record);
    SIDE_RECORD_FIELDS(PUT_FIELD)
}

static void append_frames(struct recorder *recorder, const struct hal_frame *frames, uint32_t count,
                          uint64_t timestamp, uint8_t direction)
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
        append_frame(recorder, &record);
    }
}

void recorder_write(struct recorder *recorder, const struct tick_input *in, const struct tick_output *out,
                    const struct arm_record *arm, const struct side_record *side, const struct tick_record *record)
{
    recorder->size_bytes = 0;
    append_frames(recorder, in->frames, in->frame_count, record->timestamp, 0);
    append_frames(recorder, out->frames, out->frame_count, record->timestamp, 1);
    if (arm != NULL) {
        append_arm(recorder, arm);
    }
    if (side != NULL) {
        append_side(recorder, side);
    }
    append_tick(recorder, record);
}
