/* Setpoints to frames, feedback frames to the robot's state; by the frames of berth.dbc, or to a CiA 402 drive.
 * Sending is an allow-list: a frame leaves only if its row says that it may in the supervisor's state. */
#ifndef FIRMWARE_ROBOT_CHANNEL_H
#define FIRMWARE_ROBOT_CHANNEL_H

#include "cia402.h"
#include "config.h"
#include "delivery.h"
#include "reception.h"
#include "supervisor.h"

#ifdef __cplusplus
extern "C" {
#endif

struct robot_channel {
    enum robot_profile profile;
    double position_m;    /* where the robot says it is */
    uint8_t fault;        /* the robot's controller reports a fault: in a frame of this tick, or in the newest one */
    uint8_t has_feedback; /* a frame has come in this tick */
    uint8_t is_fresh;     /* where it says it is can be relied on */
    uint8_t follows;      /* it follows setpoints: a drive has to be enabled first, another robot has echoed one */
    uint8_t sends_setpoints;   /* did so in the last tick */
    uint8_t setpoint_is_stale; /* a robot that echoes has not taken a setpoint for too long */
    uint8_t setpoint_counter;
    uint8_t status_counter;
    int64_t status_period_ticks;
    uint32_t saturated_setpoints; /* setpoints outside the range of the frame: sent at its end, and counted */
    struct cia402 drive;          /* profile "cia402" */

    uint8_t has_sides;                          /* axes beside that of the loop */
    const struct side_axis_config *side_config; /* of each of them */
    double side_position[SIDE_AXIS_COUNT];      /* where the robot says it is there: m, or rad */
    double side_sent[SIDE_AXIS_COUNT];          /* what the newest setpoints there carry */
    uint8_t side_counter[SIDE_AXIS_COUNT];      /* of their setpoints */

    int64_t setpoint_ns; /* when the newest setpoints were sent */
    int64_t setpoint_stale_after_ns;
    int64_t period_ns;
    struct setpoint_echo echo;
    struct setpoint_echo side_echo[SIDE_AXIS_COUNT];
};

/* What the robot is told in a tick. */
struct robot_command {
    double position_m;
    uint32_t limits; /* set of enum limit */
    uint32_t missed_ticks;
    uint32_t torn_samples;        /* of the force sensor, since the start */
    int reset_is_wanted;          /* a person asks to put a fault back */
    int enable_is_on;             /* and the emergency stop is not pressed */
    double side[SIDE_AXIS_COUNT]; /* on the axes beside that of the loop, if there are any: m, or rad */
};

/* Keeps a pointer to the configuration of the axes in `config`. */
void robot_channel_start(struct robot_channel *channel, const struct app_config *config);

/* Call before the first frame of a tick. */
void robot_channel_begin_tick(struct robot_channel *channel);

/* Takes a checked frame. 0 if a signal is out of range: the frame is to be rejected. */
int robot_channel_receive(struct robot_channel *channel, enum received_message message,
                          const struct hal_frame *frame);

/* Call after the last frame of a tick. */
void robot_channel_end_receive(struct robot_channel *channel, const struct reception *reception, int64_t now_ns);

/* The loop starts again: a drive is set up anew. */
void robot_channel_restart(struct robot_channel *channel);

/* Appends the frames of this tick to `out` and returns the position that the setpoint frame really carries
 * (rounded to the frame's step), in m; those of the other axes are in `side_sent`. */
double robot_channel_send(struct robot_channel *channel, const struct supervisor *supervisor,
                          const struct hal_tick *tick, const struct robot_command *command, struct tick_output *out);

#ifdef __cplusplus
}
#endif
#endif
