/* A signal's last ticks, for whoever needs to look back at it. */
#ifndef FIRMWARE_PAST_H
#define FIRMWARE_PAST_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PAST_TICKS 1024

struct past {
    uint32_t newest; /* its place: older ones stand before it, and on from the end */
    double values[PAST_TICKS];
};

/* As if it had always been `value`. */
static inline void past_fill(struct past *past, double value)
{
    for (uint32_t i = 0; i < PAST_TICKS; i++) {
        past->values[i] = value;
    }
}

/* Once a tick. */
static inline void past_add(struct past *past, double value)
{
    past->newest = (past->newest + 1u) % PAST_TICKS;
    past->values[past->newest] = value;
}

/* Whole ticks ago, less than PAST_TICKS. */
static inline double past_tick(const struct past *past, uint32_t ticks)
{
    return past->values[(past->newest + PAST_TICKS - ticks) % PAST_TICKS];
}

/* The most that past_before() looks back. */
#define PAST_TICKS_BEFORE_MAX (PAST_TICKS - 2)

/* Between ticks on straight lines; `ticks` from 0 to PAST_TICKS_BEFORE_MAX. */
static inline double past_before(const struct past *past, double ticks)
{
    const uint32_t whole = (uint32_t)ticks;
    const double share = ticks - (double)whole;
    return (1.0 - share) * past_tick(past, whole) + share * past_tick(past, whole + 1u);
}

#ifdef __cplusplus
}
#endif
#endif
