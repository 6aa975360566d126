/* The robot's axes beside that of the loop: what the tool's pose asks of them, and what the limits let through. */
#ifndef FIRMWARE_SIDE_AXES_H
#define FIRMWARE_SIDE_AXES_H

#include "limits.h"
#include "side_record.h"

#ifdef __cplusplus
extern "C" {
#endif

struct side_axes {
    const struct side_axis_config *config; /* of each */
    uint8_t any;                           /* there is one */
    uint32_t active;                       /* set of enum limit, this tick: what acts on any of them */
    struct limits limits[SIDE_AXIS_COUNT];
};

/* Every axis at rest at 0. Keeps a pointer to `config`. */
void side_axes_start(struct side_axes *axes, const struct app_config *config);

/* One tick, where there is any: the pose that is wanted in, the permitted one out. An axis that there is not stays
 * at 0. */
void side_axes_limit(struct side_axes *axes, const double wanted[SIDE_AXIS_COUNT],
                     double permitted[SIDE_AXIS_COUNT]);

/* The permitted setpoints have stopped where they were asked to be. */
int side_axes_at_rest(const struct side_axes *axes);

/* The robot, which reports `reported`, is near enough to the setpoints for the loop to start. */
int side_axes_at_place(const struct side_axes *axes, const double reported[SIDE_AXIS_COUNT]);

/* Asks all axes to come to rest as soon as they can, each by itself, and tells where that will be. */
void side_axes_stop(struct side_axes *axes, double rest[SIDE_AXIS_COUNT]);

/* In the order of enum side_axis. */
void side_record_fill(struct side_record *record, const double manipulator[SIDE_AXIS_COUNT],
                      const double command[SIDE_AXIS_COUNT], const double robot[SIDE_AXIS_COUNT],
                      const double load[SIDE_AXIS_COUNT]);

#ifdef __cplusplus
}
#endif
#endif
