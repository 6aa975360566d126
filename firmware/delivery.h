/* Whether what the loop sends arrives: frames that the bus does not take, and setpoints that the robot does not
 * echo. */
#ifndef FIRMWARE_DELIVERY_H
#define FIRMWARE_DELIVERY_H

#include "config.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Frames that found the transmit queue full, tick after tick. */
struct refusal {
    int64_t lasts_after_ns;
    int64_t since_ns;       /* the tick of the first one in the row */
    uint32_t unsent_frames; /* in all, at the last tick */
    uint8_t is_on;
};

void refusal_start(struct refusal *refusal, const struct app_config *config);

/* `unsent_frames`: in all, up to now. `sent_frames`: what the last tick, at `last_tick_ns`, wanted to send. A tick
 * that sends nothing changes nothing. */
void refusal_step(struct refusal *refusal, uint32_t unsent_frames, uint32_t sent_frames, int64_t last_tick_ns);

/* No tick has got all its frames out for longer than robot_channel.unsent_after_ms. */
int refusal_lasts(const struct refusal *refusal, int64_t now_ns);

/* The echo of one axis' setpoints: each has a counter, and the robot reports that of the newest one it has taken. */
struct setpoint_echo {
    int64_t sent_ns;  /* when the newest setpoint that is known to be taken was sent; at first, when sending began */
    uint8_t reported; /* by the robot, in its newest feedback */
    uint8_t judged;   /* reported before */
    uint8_t is_new;   /* feedback has come since it was judged */
    uint8_t is_seen;  /* since sending began */
    uint8_t is_stale; /* the newest feedback told of no setpoint that is young enough */
};

/* What the robot's feedback says. */
void setpoint_echo_report(struct setpoint_echo *echo, uint8_t counter);

/* Nothing is sent: call in each such tick. */
void setpoint_echo_rest(struct setpoint_echo *echo, int64_t now_ns);

struct setpoint_stamp {
    uint8_t counter;
    int64_t time_ns;
};

/* One tick after setpoint `newest` was sent, one a period. Without new feedback it stays as it was judged. Counters
 * tell 256 setpoints apart: one that is further behind counts as newer than it is. */
void setpoint_echo_step(struct setpoint_echo *echo, struct setpoint_stamp newest, int64_t period_ns,
                        int64_t stale_after_ns);

#ifdef __cplusplus
}
#endif
#endif
