/* The reception table: every identifier that the loop may receive has one row, and a frame that does not match
 * its row is not looked at any further. Counting and staleness live here, meaning in the channels. */
#ifndef FIRMWARE_RECEPTION_H
#define FIRMWARE_RECEPTION_H

#include "config.h"
#include "sensor_layout.h"
#include "types.h"

#ifdef __cplusplus
extern "C" {
#endif

#define RECEIVED_SIDE_FEEDBACK RECEIVED_FEEDBACK_Y

enum received_message {
    RECEIVED_ROBOT_FEEDBACK,  /* profile "berth" */
    RECEIVED_DRIVE_STATUS,    /* profile "cia402": TPDO 1 with statusword and position */
    RECEIVED_DRIVE_HEARTBEAT, /* or its boot-up message */
    RECEIVED_DRIVE_EMERGENCY,
    RECEIVED_SDO_ANSWER,
    RECEIVED_OPERATOR_MOTION,
    RECEIVED_OPERATOR_FORCE,
    RECEIVED_OPERATOR_JOINT, /* orders for an arm, where there is one */
    RECEIVED_OPERATOR_LINE,
    RECEIVED_FEEDBACK_Y, /* of the robot's axes beside that of the loop, in the order of enum side_axis */
    RECEIVED_FEEDBACK_Z,
    RECEIVED_FEEDBACK_RX,
    RECEIVED_FEEDBACK_RY,
    RECEIVED_FEEDBACK_RZ,
    RECEIVED_FORCE, /* first frame of a sample, and the others of the sensor's layout */
    RECEIVED_FORCE_LAST = RECEIVED_FORCE + SENSOR_FRAMES_MAX - 1,
    RECEIVED_COUNT,
    RECEIVED_NONE = RECEIVED_COUNT /* the frame was rejected */
};

/* Totals since the start. A frame counts once. */
struct reception_counts {
    uint32_t accepted;
    uint32_t unknown;      /* no row for this identifier on this bus */
    uint32_t wrong_length; /* shorter or longer than its row says */
    uint32_t repeated;     /* same counter as the frame before: rejected */
    uint32_t old;          /* from the past, by its stamp or by its counter: rejected */
    uint32_t out_of_range; /* a signal outside its range, or of a sample that a newer one has overtaken: rejected */
    uint32_t too_frequent; /* more than belong to the time since the last tick: taken, the newest counts */
    uint32_t lost;         /* frames missing between the counters of two accepted ones */
    uint32_t error_frames; /* the bus reported trouble */
};

struct reception_row {
    uint32_t id;
    uint8_t bus; /* HAL_BUS_COUNT: nothing is received by this row */
    uint8_t length;
    uint8_t counter_byte;
    uint8_t counter_shift;
    uint8_t counter_mask; /* the counter runs from 0 to this and starts again; 0: there is none */
    uint32_t per_tick;    /* frames that belong to one period */
    /* The ranges of the signals are checked where they are decoded, in the channel. */
};

/* The newest frame that was refused because its counter is behind. */
struct behind_frame {
    int64_t time_ns;
    uint8_t counter;
    uint8_t seen;
};

/* What has come of one message, and what may come. */
struct message_reception {
    struct reception_row row;
    int64_t stale_after_ns;
    int64_t counter_lasts_ns; /* so long its counter tells old from new */
    int64_t received_ns;      /* of the newest accepted frame; never later than its tick */
    uint8_t counter;          /* of that frame */
    uint8_t seen;             /* there has been one */
    struct behind_frame behind;
};

#define CAN_IDS 2048 /* of 11 bits */

struct reception {
    uint8_t message_of[HAL_BUS_COUNT][CAN_IDS]; /* enum received_message by bus and identifier */
    struct message_reception messages[RECEIVED_COUNT];
    int64_t now_ns;
    int64_t period_ns;
    uint32_t in_tick[RECEIVED_COUNT]; /* frames accepted in this tick */
    uint32_t periods_waited;          /* since the last tick */
    uint8_t bus_off;                  /* a controller left its bus in this tick */
    struct reception_counts counts;
};

/* Identifiers that the loop listens to on `bus`, by the same table: their number, at most RECEIVED_COUNT. */
uint32_t reception_ids(const struct app_config *config, enum hal_bus bus, uint32_t ids[RECEIVED_COUNT]);

void reception_start(struct reception *reception, const struct app_config *config);

/* Call before the first frame of a tick. `now_ns`: when the loop woke; no frame can be newer. */
void reception_begin_tick(struct reception *reception, uint32_t missed_ticks, int64_t now_ns);

/* Checks one frame against its row: identifier, bus, length, counter, age. RECEIVED_NONE if it is rejected. The
 * frame counts as accepted only after reception_accept(). */
enum received_message reception_check(struct reception *reception, const struct hal_frame *frame);

/* Takes the frame as the newest of its kind. */
void reception_accept(struct reception *reception, enum received_message message, const struct hal_frame *frame);

/* The channel found a signal out of range: the frame is dropped and its age goes on. */
void reception_reject_range(struct reception *reception);

/* No accepted frame yet, or the newest is older than its channel allows. */
int reception_is_stale(const struct reception *reception, enum received_message message, int64_t now_ns);

#ifdef __cplusplus
}
#endif
#endif
