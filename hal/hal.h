/* The seam between the firmware and whatever carries it: real buses and lines on the target, a simulated
 * rig in virtual time on a PC. Which one is chosen when the program is linked; the firmware does not know.
 *
 * Everything hangs off an opaque `struct hal`, there are no globals: one process can run many loops.
 * hal_wait_tick() is the only call that blocks and the only source of time. Every call returns a hal_status. */
#ifndef HAL_HAL_H
#define HAL_HAL_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct hal;
struct app_config;

enum hal_status {
    HAL_OK = 0,
    HAL_EMPTY,     /* can_receive: no frame has arrived */
    HAL_END,       /* wait_tick: the run is over */
    HAL_NO_BUFFER, /* can_send: the transmit queue is full, the frame is dropped and must not be retried;
                      record: the ring is full, the record is dropped and counted */
    HAL_INVALID,   /* usage or input; a message has been printed: exit code 2 */
    HAL_HARDWARE,  /* bus, line or clock failed; a message has been printed: exit code 3 */
    HAL_STATUS_COUNT
};

enum hal_bus { HAL_BUS_ROBOT, HAL_BUS_SENSOR, HAL_BUS_COUNT };

/* Lines are positive logic at this seam: 1 means what the name says. */
#define HAL_LEVEL_NOT_WIRED 2 /* of the enable line: there is none, so nobody can switch it off */
enum hal_line {
    HAL_LINE_ENABLE,         /* in:  the person at the rig allows motion */
    HAL_LINE_EMERGENCY_STOP, /* in:  emergency stop is pressed */
    HAL_LINE_HEARTBEAT,      /* out: toggles every tick */
    HAL_LINE_FAULT,          /* out: the supervisor is in fault */
    HAL_LINE_COUNT
};

enum hal_frame_flag {
    HAL_FRAME_ERROR = 1,   /* an error frame: the bus reports trouble, the data are no signal */
    HAL_FRAME_BUS_OFF = 2, /* with HAL_FRAME_ERROR: the controller has left the bus */
    HAL_FRAME_REMOTE = 4,  /* sent: asks for the frame of this identifier, and carries no data */
};

/* One classic CAN frame with an 11-bit identifier. 24 bytes, no padding. */
struct hal_frame {
    int64_t time_ns; /* received: end of frame on the bus; sent: the tick at which it was handed over */
    uint32_t id;
    uint8_t bus;    /* enum hal_bus */
    uint8_t length; /* data bytes, 0 to 8 */
    uint8_t flags;  /* enum hal_frame_flag */
    uint8_t reserved;
    uint8_t data[8];
};

/* One period of the loop. The step width is the configured period, always; these fields say what happened. */
struct hal_tick {
    int64_t index;        /* counts periods since the start, missed ones included */
    int64_t scheduled_ns; /* when the tick was due: index * period */
    int64_t woke_ns;      /* when the loop really woke */
    uint32_t missed;      /* whole periods skipped since the last tick; the phase is kept */
    uint32_t stop;        /* non-zero: somebody asked for an orderly stop */
};

/* Reads the rig named on the command line, fills `config` with the firmware's part of it and opens buses,
 * lines, clock and log. On error a message has been printed and *hal is NULL. */
enum hal_status hal_open(struct hal **hal, int argc, char **argv, struct app_config *config);

/* Closes everything and flushes the log. HAL_INVALID: the log is incomplete, and it was said. */
enum hal_status hal_close(struct hal *hal);

/* Blocks until the next tick is due. HAL_OK or HAL_END. Real hardware is not left in motion: there the end of the
 * run is first a wish to stop, tick->stop, and HAL_END comes when the robot has had the time to come to rest. */
enum hal_status hal_wait_tick(struct hal *hal, struct hal_tick *tick);

/* Takes the oldest frame that has arrived on `bus` by the current tick. Never blocks. HAL_OK or HAL_EMPTY. */
enum hal_status hal_can_receive(struct hal *hal, enum hal_bus bus, struct hal_frame *frame);

/* Hands one frame to `frame->bus`. Never blocks. HAL_OK or HAL_NO_BUFFER. */
enum hal_status hal_can_send(struct hal *hal, const struct hal_frame *frame);

/* Level of an input line: 0 or 1; of the enable line also HAL_LEVEL_NOT_WIRED. */
enum hal_status hal_gpio_get(struct hal *hal, enum hal_line line, uint8_t *level);

/* Sets an output line to 0 or 1. */
enum hal_status hal_gpio_set(struct hal *hal, enum hal_line line, uint8_t level);

/* Appends the log messages of one tick, whole or not at all. Never waits for a disk. HAL_OK or HAL_NO_BUFFER. */
enum hal_status hal_record(struct hal *hal, const void *bytes, size_t size_bytes);

#ifdef __cplusplus
}
#endif
#endif
