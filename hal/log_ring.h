/* A preallocated byte ring between one writer (the loop) and one reader (whatever brings the log to a disk).
 * Neither ever waits for the other. */
#ifndef HAL_LOG_RING_H
#define HAL_LOG_RING_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

struct log_ring {
    uint8_t *bytes;
    size_t capacity_bytes; /* a power of two */
    size_t written;        /* total bytes put in, published with release order */
    size_t taken;          /* total bytes taken out */
};

/* `bytes` stays the caller's; capacity_bytes must be a power of two. */
void log_ring_start(struct log_ring *ring, uint8_t *bytes, size_t capacity_bytes);

/* Appends all of it, or nothing and returns 0. */
int log_ring_push(struct log_ring *ring, const void *bytes, size_t size_bytes);

/* The oldest contiguous bytes; 0 if there are none. They stay valid until log_ring_take(). */
size_t log_ring_peek(const struct log_ring *ring, const uint8_t **bytes);

/* Gives `size_bytes` back that peek has shown. */
void log_ring_take(struct log_ring *ring, size_t size_bytes);

/* Bytes waiting. */
size_t log_ring_fill(const struct log_ring *ring);

#ifdef __cplusplus
}
#endif
#endif
