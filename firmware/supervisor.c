#include "supervisor.h"

#include <stddef.h>

#define BIT(state) (1u << (state))

#define FROM_START BIT(SUPERVISOR_START)
#define FROM_READY BIT(SUPERVISOR_READY)
#define FROM_RUNNING BIT(SUPERVISOR_RUNNING)
#define FROM_HOLDING BIT(SUPERVISOR_HOLDING)
#define FROM_FAULT BIT(SUPERVISOR_FAULT)
#define FROM_ALIVE (FROM_START | FROM_READY | FROM_RUNNING | FROM_HOLDING)
#define FROM_ACTIVE (FROM_READY | FROM_RUNNING | FROM_HOLDING)
#define FROM_ANY (FROM_ALIVE | FROM_FAULT)

#define TROUBLE                                                                                                     \
    (CONDITION_EMERGENCY_STOP | CONDITION_ROBOT_FAULT | CONDITION_SENSOR_SATURATED | CONDITION_FORCE_LIMIT |        \
     CONDITION_BUS_OFF | CONDITION_NOT_FINITE | CONDITION_SEND_REFUSED)
#define FRESH (CONDITION_FEEDBACK_FRESH | CONDITION_SENSOR_FRESH | CONDITION_OPERATOR_FRESH)

/* In the table: the cause of an earlier stop stays. */
#define STOP_KEPT STOP_CAUSE_COUNT

struct transition {
    uint32_t from;    /* set of states */
    uint32_t all_of;  /* conditions that must hold */
    uint32_t none_of; /* conditions that must not */
    enum supervisor_state to;
    enum stop_cause cause;
};

static const struct transition transitions[] = {
    {FROM_START, CONDITION_STOP, 0, SUPERVISOR_STOPPED, STOP_REQUESTED},

    {FROM_ALIVE, CONDITION_EMERGENCY_STOP, 0, SUPERVISOR_FAULT, STOP_EMERGENCY_STOP},
    {FROM_ALIVE, CONDITION_BUS_OFF, 0, SUPERVISOR_FAULT, STOP_BUS_OFF},
    {FROM_ALIVE, CONDITION_ROBOT_FAULT, 0, SUPERVISOR_FAULT, STOP_ROBOT_FAULT},
    {FROM_ACTIVE, CONDITION_NOT_FINITE, 0, SUPERVISOR_FAULT, STOP_NOT_FINITE},
    {FROM_ACTIVE, 0, CONDITION_FEEDBACK_FRESH, SUPERVISOR_FAULT, STOP_FEEDBACK_STALE},
    {FROM_ACTIVE, CONDITION_SENSOR_SATURATED, 0, SUPERVISOR_FAULT, STOP_SENSOR_SATURATED},
    {FROM_ACTIVE, CONDITION_FORCE_LIMIT, 0, SUPERVISOR_FAULT, STOP_FORCE_LIMIT},
    {FROM_ACTIVE, CONDITION_POSITION_LIMIT, 0, SUPERVISOR_FAULT, STOP_POSITION_LIMIT},
    {FROM_ACTIVE, CONDITION_MISSED_TICKS, 0, SUPERVISOR_FAULT, STOP_MISSED_TICKS},
    {FROM_ACTIVE, CONDITION_SEND_REFUSED, 0, SUPERVISOR_FAULT, STOP_SEND_REFUSED},
    {FROM_ACTIVE, CONDITION_SETPOINT_STALE, 0, SUPERVISOR_FAULT, STOP_SETPOINT_STALE},
    {FROM_ACTIVE, CONDITION_FOLLOWING_ERROR, 0, SUPERVISOR_FAULT, STOP_FOLLOWING_ERROR},
    {FROM_RUNNING, CONDITION_LINK_QUALITY, 0, SUPERVISOR_FAULT, STOP_LINK_QUALITY},
    {FROM_RUNNING, CONDITION_DEAD_TIME_POWER, 0, SUPERVISOR_FAULT, STOP_DEAD_TIME_POWER},
    {FROM_RUNNING, CONDITION_GROWTH, 0, SUPERVISOR_FAULT, STOP_GROWTH},

    {FROM_READY, CONDITION_STOP | CONDITION_AT_REST, 0, SUPERVISOR_STOPPED, STOP_REQUESTED},
    {FROM_HOLDING | FROM_FAULT, CONDITION_STOP | CONDITION_AT_REST, 0, SUPERVISOR_STOPPED, STOP_KEPT},
    {FROM_RUNNING, CONDITION_STOP, 0, SUPERVISOR_HOLDING, STOP_REQUESTED},

    {FROM_RUNNING, 0, CONDITION_ENABLE, SUPERVISOR_HOLDING, STOP_ENABLE_OFF},
    {FROM_READY | FROM_RUNNING, 0, CONDITION_SENSOR_FRESH, SUPERVISOR_HOLDING, STOP_SENSOR_STALE},
    {FROM_READY | FROM_RUNNING, 0, CONDITION_OPERATOR_FRESH, SUPERVISOR_HOLDING, STOP_OPERATOR_STALE},
    {FROM_RUNNING, CONDITION_REQUEST_HOLD, 0, SUPERVISOR_HOLDING, STOP_REQUESTED},

    {FROM_START, FRESH | CONDITION_ROBOT_AT_PLACE, CONDITION_STOP | TROUBLE, SUPERVISOR_READY, STOP_NONE},
    {FROM_READY, FRESH | CONDITION_ENABLE | CONDITION_ROBOT_FOLLOWS | CONDITION_REQUEST_RUN, CONDITION_STOP,
     SUPERVISOR_RUNNING, STOP_NONE},
    {FROM_HOLDING, FRESH | CONDITION_ENABLE | CONDITION_AT_REST, CONDITION_REQUEST_RUN, SUPERVISOR_READY, STOP_NONE},
    {FROM_FAULT, CONDITION_REQUEST_RESET | CONDITION_AT_REST, TROUBLE, SUPERVISOR_START, STOP_NONE},
};

static const char *const state_names[] = {
    [SUPERVISOR_START] = "start",     [SUPERVISOR_READY] = "ready", [SUPERVISOR_RUNNING] = "running",
    [SUPERVISOR_HOLDING] = "holding", [SUPERVISOR_FAULT] = "fault", [SUPERVISOR_STOPPED] = "stopped",
};
_Static_assert(sizeof state_names / sizeof state_names[0] == SUPERVISOR_STATE_COUNT, "one name per state");

static const char *const cause_names[] = {
    [STOP_NONE] = "none",
    [STOP_REQUESTED] = "requested",
    [STOP_ENABLE_OFF] = "enable_off",
    [STOP_SENSOR_STALE] = "sensor_stale",
    [STOP_OPERATOR_STALE] = "operator_stale",
    [STOP_EMERGENCY_STOP] = "emergency_stop",
    [STOP_FEEDBACK_STALE] = "feedback_stale",
    [STOP_ROBOT_FAULT] = "robot_fault",
    [STOP_SENSOR_SATURATED] = "sensor_saturated",
    [STOP_FORCE_LIMIT] = "force_limit",
    [STOP_POSITION_LIMIT] = "position_limit",
    [STOP_NOT_FINITE] = "not_finite",
    [STOP_BUS_OFF] = "bus_off",
    [STOP_MISSED_TICKS] = "missed_ticks",
    [STOP_SEND_REFUSED] = "send_refused",
    [STOP_SETPOINT_STALE] = "setpoint_stale",
    [STOP_FOLLOWING_ERROR] = "following_error",
    [STOP_LINK_QUALITY] = "link_quality",
    [STOP_DEAD_TIME_POWER] = "dead_time_power",
    [STOP_GROWTH] = "growth",
};
_Static_assert(sizeof cause_names / sizeof cause_names[0] == STOP_CAUSE_COUNT, "one name per cause");

void supervisor_start(struct supervisor *supervisor)
{
    *supervisor = (struct supervisor){.state = SUPERVISOR_START, .stop_cause = STOP_NONE};
}

/* By state, the conditions that count only after they were seen off. The table sees all others as they are: a
 * request to run that is still there keeps the loop in holding. */
static const uint32_t persons_conditions[SUPERVISOR_STATE_COUNT] = {
    [SUPERVISOR_READY] = CONDITION_ENABLE | CONDITION_REQUEST_RUN,
    [SUPERVISOR_HOLDING] = CONDITION_ENABLE,
    [SUPERVISOR_FAULT] = CONDITION_REQUEST_RESET,
};

uint32_t supervisor_counting(enum supervisor_state state, uint32_t seen_off, uint32_t conditions)
{
    const uint32_t fresh = seen_off | (conditions & CONDITION_ENABLE_NOT_WIRED ? CONDITION_ENABLE : 0u);
    return conditions & ~(persons_conditions[state] & ~fresh);
}

/* What was seen off counts as long as the loop only waits: an enable that was given in start or holding need not be
 * given again in ready. */
static uint32_t still_seen_off(uint32_t seen_off, enum supervisor_state from, enum supervisor_state to)
{
    const int goes_on_waiting = from != SUPERVISOR_RUNNING && (to == SUPERVISOR_READY || to == SUPERVISOR_HOLDING);
    return goes_on_waiting ? seen_off & CONDITION_ENABLE : 0u;
}

void supervisor_step(struct supervisor *supervisor, uint32_t given_conditions)
{
    supervisor->seen_off |= ~given_conditions & PERSONS_CONDITIONS;
    const uint32_t conditions = supervisor_counting(supervisor->state, supervisor->seen_off, given_conditions);
    if (supervisor->settled && conditions == supervisor->settled_conditions) {
        return;
    }
    const uint32_t from = BIT(supervisor->state);
    for (size_t i = 0; i < sizeof transitions / sizeof transitions[0]; i++) {
        const struct transition *row = &transitions[i];
        if ((row->from & from) && (conditions & row->all_of) == row->all_of && !(conditions & row->none_of)) {
            supervisor->seen_off = still_seen_off(supervisor->seen_off, supervisor->state, row->to);
            supervisor->state = row->to;
            supervisor->stop_cause = row->cause == STOP_KEPT ? supervisor->stop_cause : row->cause;
            supervisor->settled = 0;
            return;
        }
    }
    supervisor->settled_conditions = conditions;
    supervisor->settled = 1;
}

int supervisor_hears_reset(const struct supervisor *supervisor, uint32_t conditions)
{
    return (conditions & supervisor->seen_off & CONDITION_REQUEST_RESET) != 0;
}

int supervisor_may_move(const struct supervisor *supervisor)
{
    return supervisor->state == SUPERVISOR_RUNNING;
}

const char *supervisor_state_name(enum supervisor_state state)
{
    return (unsigned)state < SUPERVISOR_STATE_COUNT ? state_names[state] : "unknown";
}

const char *stop_cause_name(enum stop_cause cause)
{
    return (unsigned)cause < STOP_CAUSE_COUNT ? cause_names[cause] : "unknown";
}
