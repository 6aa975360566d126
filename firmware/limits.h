/* Last stage before the wire: whatever comes in, what goes out is finite, inside the position range, and no
 * faster and no harder than configured. A setpoint that respects the limits passes unchanged, bit for bit. */
#ifndef FIRMWARE_LIMITS_H
#define FIRMWARE_LIMITS_H

#include <stdint.h>

#include "config.h"

#ifdef __cplusplus
extern "C" {
#endif

/* "Now limited by": set while a limit acts. */
enum limit {
    LIMIT_NOT_FINITE = 1 << 0,
    LIMIT_POSITION = 1 << 1,
    LIMIT_VELOCITY = 1 << 2,
    LIMIT_ACCELERATION = 1 << 3,
};

#define LIMIT_COUNT 4
extern const char *const limit_names[LIMIT_COUNT]; /* by bit number */

struct limits {
    const struct limits_config *config;
    double period_s;
    double target_m;   /* what was asked for at the last tick */
    double position_m; /* what was let through */
    double velocity_m_per_s;
    uint32_t active; /* set of enum limit, this tick */
    uint32_t active_ticks[LIMIT_COUNT];
};

/* Of the loop's axis: starts at rest at the manipulator's initial position. Keeps a pointer to `config`. */
void limits_start(struct limits *limits, const struct app_config *config);

/* Of any axis: starts at rest at `position_m`. Keeps a pointer to `config`. */
void limits_start_at(struct limits *limits, const struct limits_config *config, double period_s, double position_m);

/* One tick: the wanted position in, the permitted one out, both in m; of an axis that turns, in rad. */
double limits_step(struct limits *limits, double wanted_m);

/* Asks the setpoints to come to rest as soon as they can: they brake by the acceleration limit and do not turn back.
 * Returns where that will be, which is to be asked for until then. */
double limits_stop(struct limits *limits);

/* The permitted setpoints have stopped where they were asked to be. */
int limits_at_rest(const struct limits *limits);

#ifdef __cplusplus
}
#endif
#endif
