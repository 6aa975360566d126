/* The only owner of the question whether the robot may move. One const transition table; the first row that
 * fits decides. */
#ifndef FIRMWARE_SUPERVISOR_H
#define FIRMWARE_SUPERVISOR_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum supervisor_state {
    SUPERVISOR_START,   /* nothing is sent; waits for feedback, force and operator, and a robot at its place */
    SUPERVISOR_READY,   /* everything is fresh; the robot is held, the manipulator does not integrate */
    SUPERVISOR_RUNNING, /* the manipulator integrates, the robot follows */
    SUPERVISOR_HOLDING, /* led to rest for a reason that may pass; goes on only by way of ready */
    SUPERVISOR_FAULT,   /* led to rest for a reason that needs a person: leaves on a reset request */
    SUPERVISOR_STOPPED, /* the run is over: reached at rest, or from start */
    SUPERVISOR_STATE_COUNT
};

/* "Stopped because": kept from the moment that the robot was stopped until it is ready again or a person has reset
 * the fault; the end of the run does not replace it. */
enum stop_cause {
    STOP_NONE,
    /* holding */
    STOP_REQUESTED,
    STOP_ENABLE_OFF,
    STOP_SENSOR_STALE,
    STOP_OPERATOR_STALE,
    /* fault */
    STOP_EMERGENCY_STOP,
    STOP_FEEDBACK_STALE,
    STOP_ROBOT_FAULT,
    STOP_SENSOR_SATURATED,
    STOP_FORCE_LIMIT,
    STOP_POSITION_LIMIT,
    STOP_NOT_FINITE,
    STOP_BUS_OFF,
    STOP_MISSED_TICKS,
    STOP_SEND_REFUSED,
    STOP_SETPOINT_STALE,
    STOP_FOLLOWING_ERROR,
    STOP_LINK_QUALITY,
    STOP_DEAD_TIME_POWER,
    STOP_GROWTH,
    STOP_CAUSE_COUNT
};

/* What the supervisor decides from, one bit each. */
enum supervisor_condition {
    CONDITION_EMERGENCY_STOP = 1 << 0,
    CONDITION_ENABLE = 1 << 1,
    CONDITION_FEEDBACK_FRESH = 1 << 2,
    CONDITION_SENSOR_FRESH = 1 << 3,
    CONDITION_OPERATOR_FRESH = 1 << 4,
    CONDITION_ROBOT_AT_PLACE = 1 << 5, /* feedback within the start tolerance of the setpoint */
    CONDITION_ROBOT_FAULT = 1 << 6,
    CONDITION_SENSOR_SATURATED = 1 << 7,
    CONDITION_FORCE_LIMIT = 1 << 8,
    CONDITION_POSITION_LIMIT = 1 << 9,
    CONDITION_NOT_FINITE = 1 << 10,
    CONDITION_BUS_OFF = 1 << 11,
    CONDITION_MISSED_TICKS = 1 << 12,
    CONDITION_REQUEST_HOLD = 1 << 13,
    CONDITION_REQUEST_RUN = 1 << 14,
    CONDITION_REQUEST_RESET = 1 << 15,
    CONDITION_STOP = 1 << 16,
    CONDITION_AT_REST = 1 << 17,        /* the setpoints have come to rest */
    CONDITION_ROBOT_FOLLOWS = 1 << 18,  /* it is enabled and follows setpoints */
    CONDITION_SEND_REFUSED = 1 << 19,   /* the bus takes no frames */
    CONDITION_SETPOINT_STALE = 1 << 20, /* the robot does not echo setpoints any more */
    CONDITION_FOLLOWING_ERROR = 1 << 21,
    CONDITION_LINK_QUALITY = 1 << 22, /* too few reports or samples come */
    CONDITION_DEAD_TIME_POWER = 1 << 23,
    CONDITION_GROWTH = 1 << 24, /* the loop diverges */
    /* Not in the table: with it the enable need not be seen off, as nobody can switch it off. */
    CONDITION_ENABLE_NOT_WIRED = 1 << 30,
};

/* What a person does: it counts only after it was seen off, so that what merely stands there moves nothing. */
#define PERSONS_CONDITIONS (CONDITION_ENABLE | CONDITION_REQUEST_RUN | CONDITION_REQUEST_RESET)

struct supervisor {
    enum supervisor_state state;
    enum stop_cause stop_cause;
    uint32_t seen_off;           /* of PERSONS_CONDITIONS, those that were off since they last had to be */
    uint32_t settled_conditions; /* no row fits these in this state: the table need not be read again */
    uint32_t settled;
};

void supervisor_start(struct supervisor *supervisor);

/* Those of `conditions` that count in `state`, without what a person would have to do anew: to request run in ready
 * and reset in fault, and to enable while the loop waits. A pure function. */
uint32_t supervisor_counting(enum supervisor_state state, uint32_t seen_off, uint32_t conditions);

/* One tick: applies the first row of the table that fits what counts of `conditions` (bits of supervisor_condition).
 */
void supervisor_step(struct supervisor *supervisor, uint32_t conditions);

/* A person asks for a reset, and began to do so in this state. */
int supervisor_hears_reset(const struct supervisor *supervisor, uint32_t conditions);

/* The manipulator may integrate and the robot may follow it. */
int supervisor_may_move(const struct supervisor *supervisor);

const char *supervisor_state_name(enum supervisor_state state);
const char *stop_cause_name(enum stop_cause cause);

#ifdef __cplusplus
}
#endif
#endif
