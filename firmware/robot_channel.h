/* Setpoints to frames, feedback frames to the robot's state. Sending is an allow-list: a frame leaves only if
 * its row says that it may in the supervisor's state. */
#ifndef FIRMWARE_ROBOT_CHANNEL_H
#define FIRMWARE_ROBOT_CHANNEL_H

#include "config.h"
#include "reception.h"
#include "supervisor.h"

#ifdef __cplusplus
extern "C" {
#endif

struct robot_channel {
    double position_m;    /* where the robot says it is */
    uint8_t fault;        /* the robot's controller reports a fault: in a frame of this tick, or in the newest one */
    uint8_t has_feedback; /* a frame has come in this tick */
    uint8_t setpoint_counter;
    uint8_t status_counter;
    int64_t status_period_ticks;
    uint32_t saturated_setpoints; /* setpoints outside the range of the frame: sent at its end, and counted */
};

void robot_channel_start(struct robot_channel *channel, const struct app_config *config);

/* Call before the first frame of a tick. */
void robot_channel_begin_tick(struct robot_channel *channel);

/* Takes a checked feedback frame. 0 if a signal is out of range: the frame is to be rejected. */
int robot_channel_receive(struct robot_channel *channel, const struct hal_frame *frame);

/* Appends the frames of this tick to `out` and returns the position that the setpoint frame really carries
 * (rounded to the frame's step), in m. */
double robot_channel_send(struct robot_channel *channel, const struct supervisor *supervisor,
                          const struct hal_tick *tick, double command_position_m, uint32_t limits,
                          uint32_t missed_ticks, struct tick_output *out);

#ifdef __cplusplus
}
#endif
#endif
