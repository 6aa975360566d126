/* What enters and leaves one tick. Everything that the step may depend on is in tick_input, or in the state
 * that earlier ticks left: recorded inputs therefore replay to the same outputs, bit for bit. */
#ifndef FIRMWARE_TYPES_H
#define FIRMWARE_TYPES_H

#include "../hal/hal.h"

/* Frames taken per tick, all buses together. Three arrive in a regular tick; the rest is room for bursts and for
 * sensors with many frames a tick. What does not fit waits in the HAL for the next tick. */
#define TICK_FRAMES_IN_MAX 64
#define TICK_SENSOR_FRAMES_MAX (TICK_FRAMES_IN_MAX / 2)
#define TICK_FRAMES_OUT_MAX 8 /* setpoints of six axes, status, and one to spare */

struct tick_input {
    struct hal_tick tick;
    uint32_t frame_count;
    uint32_t unsent_frames; /* of all ticks before: dropped, never retried */
    uint8_t enable;         /* or HAL_LEVEL_NOT_WIRED */
    uint8_t emergency_stop;
    struct hal_frame frames[TICK_FRAMES_IN_MAX];
};

struct tick_output {
    uint32_t frame_count;
    uint8_t heartbeat;
    uint8_t fault;
    struct hal_frame frames[TICK_FRAMES_OUT_MAX];
};

#endif
