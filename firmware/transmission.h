/* Sending is an allow-list: a frame leaves only if its row says that it may in the supervisor's state. */
#ifndef FIRMWARE_TRANSMISSION_H
#define FIRMWARE_TRANSMISSION_H

#include <string.h>

#include "supervisor.h"
#include "types.h"

#define STATE_BIT(state) (1u << (state))

struct transmission_row {
    uint32_t id;
    uint8_t length;
    uint32_t allowed_states; /* STATE_BIT() of each */
};

/* Appends a frame with `data` to the robot's bus, unless `row` forbids it in this state. `node_id` is added to the
 * row's identifier. Returns the number of frames appended. */
static inline int transmit(struct tick_output *out, const struct transmission_row *row, uint32_t node_id,
                           const struct supervisor *supervisor, const struct hal_tick *tick, const uint8_t data[8])
{
    if (!(row->allowed_states & STATE_BIT(supervisor->state)) || out->frame_count >= TICK_FRAMES_OUT_MAX) {
        return 0;
    }
    struct hal_frame *frame = &out->frames[out->frame_count++];
    *frame = (struct hal_frame){
        .time_ns = tick->scheduled_ns, .id = row->id + node_id, .bus = HAL_BUS_ROBOT, .length = row->length};
    memcpy(frame->data, data, sizeof frame->data);
    return 1;
}

#endif
