#include "log_ring.h"

#include <string.h>

void log_ring_start(struct log_ring *ring, uint8_t *bytes, size_t capacity_bytes)
{
    *ring = (struct log_ring){.bytes = bytes, .capacity_bytes = capacity_bytes};
}

int log_ring_push(struct log_ring *ring, const void *bytes, size_t size_bytes)
{
    const size_t taken = __atomic_load_n(&ring->taken, __ATOMIC_ACQUIRE);
    if (size_bytes > ring->capacity_bytes - (ring->written - taken)) {
        return 0;
    }
    const size_t at = ring->written & (ring->capacity_bytes - 1);
    const size_t to_end = ring->capacity_bytes - at;
    const size_t first = size_bytes < to_end ? size_bytes : to_end;
    memcpy(ring->bytes + at, bytes, first);
    memcpy(ring->bytes, (const uint8_t *)bytes + first, size_bytes - first);
    __atomic_store_n(&ring->written, ring->written + size_bytes, __ATOMIC_RELEASE);
    return 1;
}

size_t log_ring_peek(const struct log_ring *ring, const uint8_t **bytes)
{
    const size_t waiting = __atomic_load_n(&ring->written, __ATOMIC_ACQUIRE) - ring->taken;
    const size_t at = ring->taken & (ring->capacity_bytes - 1);
    const size_t to_end = ring->capacity_bytes - at;
    *bytes = ring->bytes + at;
    return waiting < to_end ? waiting : to_end;
}

void log_ring_take(struct log_ring *ring, size_t size_bytes)
{
    __atomic_store_n(&ring->taken, ring->taken + size_bytes, __ATOMIC_RELEASE);
}

size_t log_ring_fill(const struct log_ring *ring)
{
    return __atomic_load_n(&ring->written, __ATOMIC_ACQUIRE) - __atomic_load_n(&ring->taken, __ATOMIC_ACQUIRE);
}
