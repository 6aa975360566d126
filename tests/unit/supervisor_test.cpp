#include <doctest/doctest.h>

#include <cstring>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "firmware/supervisor.h"

namespace
{

constexpr std::uint32_t condition_bits = 25;
constexpr std::uint32_t fresh = CONDITION_FEEDBACK_FRESH | CONDITION_SENSOR_FRESH | CONDITION_OPERATOR_FRESH;
constexpr std::uint32_t healthy =
    fresh | CONDITION_ENABLE | CONDITION_ROBOT_AT_PLACE | CONDITION_AT_REST | CONDITION_ROBOT_FOLLOWS;
/* What must be over before a fault can be left. Missed ticks, the position limit and the echo of setpoints are put
 * back by the reset. */
constexpr std::uint32_t trouble = CONDITION_EMERGENCY_STOP | CONDITION_ROBOT_FAULT | CONDITION_SENSOR_SATURATED |
                                  CONDITION_FORCE_LIMIT | CONDITION_BUS_OFF | CONDITION_NOT_FINITE |
                                  CONDITION_SEND_REFUSED;

using outcome = std::pair<supervisor_state, stop_cause>;

/* A cause that fits the state, as an earlier stop would have left it. */
stop_cause earlier_cause(supervisor_state state)
{
    return state == SUPERVISOR_HOLDING   ? STOP_SENSOR_STALE
           : state == SUPERVISOR_FAULT   ? STOP_ROBOT_FAULT
           : state == SUPERVISOR_STOPPED ? STOP_REQUESTED
                                         : STOP_NONE;
}

outcome step(supervisor_state state, std::uint32_t conditions)
{
    supervisor supervisor;
    supervisor_start(&supervisor);
    supervisor.state = state;
    supervisor.stop_cause = earlier_cause(state);
    supervisor.seen_off = PERSONS_CONDITIONS; /* the table by itself; what was not seen off: edges_test.cpp */
    supervisor_step(&supervisor, conditions);
    return {supervisor.state, supervisor.stop_cause};
}

/* One condition at a time turned over in an otherwise healthy rig: what changes; `otherwise` is what does not. */
struct expected_transitions {
    supervisor_state from;
    outcome otherwise;
    std::map<std::uint32_t, outcome> turned;
};

constexpr outcome fault(stop_cause cause)
{
    return {SUPERVISOR_FAULT, cause};
}
constexpr outcome holding(stop_cause cause)
{
    return {SUPERVISOR_HOLDING, cause};
}
const outcome start = {SUPERVISOR_START, STOP_NONE}, ready = {SUPERVISOR_READY, STOP_NONE};
const outcome running = {SUPERVISOR_RUNNING, STOP_NONE}, stopped = {SUPERVISOR_STOPPED, STOP_REQUESTED};
const outcome held_before = holding(STOP_SENSOR_STALE), faulty_before = fault(STOP_ROBOT_FAULT);

const expected_transitions transition_table[] = {
    {SUPERVISOR_START,
     ready,
     {{CONDITION_EMERGENCY_STOP, fault(STOP_EMERGENCY_STOP)},
      {CONDITION_BUS_OFF, fault(STOP_BUS_OFF)},
      {CONDITION_ROBOT_FAULT, fault(STOP_ROBOT_FAULT)},
      {CONDITION_FEEDBACK_FRESH, start},
      {CONDITION_SENSOR_FRESH, start},
      {CONDITION_OPERATOR_FRESH, start},
      {CONDITION_ROBOT_AT_PLACE, start},
      {CONDITION_SENSOR_SATURATED, start},
      {CONDITION_FORCE_LIMIT, start},
      {CONDITION_NOT_FINITE, start},
      {CONDITION_SEND_REFUSED, start},
      {CONDITION_STOP, stopped}}},
    {SUPERVISOR_READY,
     ready,
     {{CONDITION_EMERGENCY_STOP, fault(STOP_EMERGENCY_STOP)},
      {CONDITION_BUS_OFF, fault(STOP_BUS_OFF)},
      {CONDITION_ROBOT_FAULT, fault(STOP_ROBOT_FAULT)},
      {CONDITION_NOT_FINITE, fault(STOP_NOT_FINITE)},
      {CONDITION_FEEDBACK_FRESH, fault(STOP_FEEDBACK_STALE)},
      {CONDITION_SENSOR_SATURATED, fault(STOP_SENSOR_SATURATED)},
      {CONDITION_FORCE_LIMIT, fault(STOP_FORCE_LIMIT)},
      {CONDITION_POSITION_LIMIT, fault(STOP_POSITION_LIMIT)},
      {CONDITION_MISSED_TICKS, fault(STOP_MISSED_TICKS)},
      {CONDITION_SEND_REFUSED, fault(STOP_SEND_REFUSED)},
      {CONDITION_SETPOINT_STALE, fault(STOP_SETPOINT_STALE)},
      {CONDITION_FOLLOWING_ERROR, fault(STOP_FOLLOWING_ERROR)},
      {CONDITION_SENSOR_FRESH, holding(STOP_SENSOR_STALE)},
      {CONDITION_OPERATOR_FRESH, holding(STOP_OPERATOR_STALE)},
      {CONDITION_REQUEST_RUN, running},
      {CONDITION_STOP, stopped}}},
    {SUPERVISOR_RUNNING,
     running,
     {{CONDITION_EMERGENCY_STOP, fault(STOP_EMERGENCY_STOP)},
      {CONDITION_BUS_OFF, fault(STOP_BUS_OFF)},
      {CONDITION_ROBOT_FAULT, fault(STOP_ROBOT_FAULT)},
      {CONDITION_NOT_FINITE, fault(STOP_NOT_FINITE)},
      {CONDITION_FEEDBACK_FRESH, fault(STOP_FEEDBACK_STALE)},
      {CONDITION_SENSOR_SATURATED, fault(STOP_SENSOR_SATURATED)},
      {CONDITION_FORCE_LIMIT, fault(STOP_FORCE_LIMIT)},
      {CONDITION_POSITION_LIMIT, fault(STOP_POSITION_LIMIT)},
      {CONDITION_MISSED_TICKS, fault(STOP_MISSED_TICKS)},
      {CONDITION_SEND_REFUSED, fault(STOP_SEND_REFUSED)},
      {CONDITION_SETPOINT_STALE, fault(STOP_SETPOINT_STALE)},
      {CONDITION_FOLLOWING_ERROR, fault(STOP_FOLLOWING_ERROR)},
      {CONDITION_ENABLE, holding(STOP_ENABLE_OFF)},
      {CONDITION_SENSOR_FRESH, holding(STOP_SENSOR_STALE)},
      {CONDITION_OPERATOR_FRESH, holding(STOP_OPERATOR_STALE)},
      {CONDITION_LINK_QUALITY, fault(STOP_LINK_QUALITY)},
      {CONDITION_DEAD_TIME_POWER, fault(STOP_DEAD_TIME_POWER)},
      {CONDITION_GROWTH, fault(STOP_GROWTH)},
      {CONDITION_REQUEST_HOLD, holding(STOP_REQUESTED)},
      {CONDITION_STOP, holding(STOP_REQUESTED)}}},
    {SUPERVISOR_HOLDING,
     ready,
     {{CONDITION_EMERGENCY_STOP, fault(STOP_EMERGENCY_STOP)},
      {CONDITION_BUS_OFF, fault(STOP_BUS_OFF)},
      {CONDITION_ROBOT_FAULT, fault(STOP_ROBOT_FAULT)},
      {CONDITION_NOT_FINITE, fault(STOP_NOT_FINITE)},
      {CONDITION_FEEDBACK_FRESH, fault(STOP_FEEDBACK_STALE)},
      {CONDITION_SENSOR_SATURATED, fault(STOP_SENSOR_SATURATED)},
      {CONDITION_FORCE_LIMIT, fault(STOP_FORCE_LIMIT)},
      {CONDITION_POSITION_LIMIT, fault(STOP_POSITION_LIMIT)},
      {CONDITION_MISSED_TICKS, fault(STOP_MISSED_TICKS)},
      {CONDITION_SEND_REFUSED, fault(STOP_SEND_REFUSED)},
      {CONDITION_SETPOINT_STALE, fault(STOP_SETPOINT_STALE)},
      {CONDITION_FOLLOWING_ERROR, fault(STOP_FOLLOWING_ERROR)},
      {CONDITION_ENABLE, held_before},
      {CONDITION_SENSOR_FRESH, held_before},
      {CONDITION_OPERATOR_FRESH, held_before},
      {CONDITION_AT_REST, held_before},
      {CONDITION_REQUEST_RUN, held_before},
      {CONDITION_STOP, {SUPERVISOR_STOPPED, STOP_SENSOR_STALE}}}},
    {SUPERVISOR_FAULT,
     faulty_before,
     {{CONDITION_REQUEST_RESET, start}, {CONDITION_STOP, {SUPERVISOR_STOPPED, STOP_ROBOT_FAULT}}}},
    {SUPERVISOR_STOPPED, stopped, {}},
};

/* What must hold of every step, whatever the conditions: the number of the first rule that is broken, or 0. */
int broken_rule(supervisor_state from, std::uint32_t conditions, const outcome &result)
{
    const auto has = [=](std::uint32_t all) { return (conditions & all) == all; };
    const auto has_any = [=](std::uint32_t any) { return (conditions & any) != 0; };
    const auto [to, cause] = result;
    const bool may_run = has(fresh | CONDITION_ENABLE) &&
                         !has_any(trouble | CONDITION_POSITION_LIMIT | CONDITION_MISSED_TICKS |
                                  CONDITION_SETPOINT_STALE | CONDITION_FOLLOWING_ERROR | CONDITION_STOP);
    const bool enters_running = from == SUPERVISOR_READY && has(CONDITION_REQUEST_RUN | CONDITION_ROBOT_FOLLOWS);
    const bool stays_running =
        from == SUPERVISOR_RUNNING &&
        !has_any(CONDITION_REQUEST_HOLD | CONDITION_LINK_QUALITY | CONDITION_DEAD_TIME_POWER | CONDITION_GROWTH);
    if (to == SUPERVISOR_RUNNING && !(may_run && (enters_running || stays_running))) {
        return 1;
    }
    if (has_any(CONDITION_EMERGENCY_STOP) && to != SUPERVISOR_FAULT && to != SUPERVISOR_STOPPED) {
        return 2;
    }
    if (from == SUPERVISOR_STOPPED && to != SUPERVISOR_STOPPED) {
        return 3;
    }
    if (from == SUPERVISOR_FAULT && to == SUPERVISOR_START &&
        (!has(CONDITION_REQUEST_RESET | CONDITION_AT_REST) || has_any(trouble))) {
        return 4;
    }
    if (from == SUPERVISOR_FAULT &&
        (to == SUPERVISOR_READY || to == SUPERVISOR_RUNNING || to == SUPERVISOR_HOLDING)) {
        return 5;
    }
    if (from == SUPERVISOR_HOLDING && to == SUPERVISOR_READY && has_any(CONDITION_REQUEST_RUN)) {
        return 6;
    }
    /* The robot is at rest, or has never been sent anything, when the setpoints end. */
    if (from != SUPERVISOR_STOPPED && to == SUPERVISOR_STOPPED &&
        !(has(CONDITION_STOP) && (from == SUPERVISOR_START || has(CONDITION_AT_REST)))) {
        return 7;
    }
    const bool is_holding_cause = cause >= STOP_REQUESTED && cause <= STOP_OPERATOR_STALE;
    const bool cause_fits = to == SUPERVISOR_HOLDING   ? is_holding_cause
                            : to == SUPERVISOR_FAULT   ? cause >= STOP_EMERGENCY_STOP && cause < STOP_CAUSE_COUNT
                            : to == SUPERVISOR_STOPPED ? cause != STOP_NONE
                                                       : cause == STOP_NONE;
    if (!cause_fits) {
        return 8;
    }
    if (to == SUPERVISOR_STOPPED && earlier_cause(from) != STOP_NONE && cause != earlier_cause(from)) {
        return 9; /* the end of the run hides why the robot was stopped */
    }
    return 0;
}

} // namespace

TEST_CASE("supervisor: each single condition in each state leads where it is documented")
{
    CHECK(sizeof transition_table / sizeof transition_table[0] == SUPERVISOR_STATE_COUNT);
    for (const expected_transitions &row : transition_table) {
        CAPTURE(std::string(supervisor_state_name(row.from)));
        CHECK(step(row.from, healthy) == row.otherwise);
        for (std::uint32_t bit = 0; bit < condition_bits; bit++) {
            CAPTURE(bit);
            const auto expected = row.turned.find(1u << bit);
            const outcome result = step(row.from, healthy ^ (1u << bit));
            const outcome wanted = expected != row.turned.end() ? expected->second : row.otherwise;
            CHECK(std::string(supervisor_state_name(result.first)) ==
                  std::string(supervisor_state_name(wanted.first)));
            CHECK(std::string(stop_cause_name(result.second)) == std::string(stop_cause_name(wanted.second)));
        }
    }
}

TEST_CASE("supervisor: the rules hold for every state and all 2^25 sets of conditions")
{
    for (int from = 0; from < SUPERVISOR_STATE_COUNT; from++) {
        std::uint32_t broken = 0, first_conditions = 0;
        int first_rule = 0;
        for (std::uint32_t conditions = 0; conditions < 1u << condition_bits; conditions++) {
            const auto state = static_cast<supervisor_state>(from);
            const int rule = broken_rule(state, conditions, step(state, conditions));
            if (rule != 0 && broken++ == 0) {
                first_rule = rule;
                first_conditions = conditions;
            }
        }
        CAPTURE(from);
        CAPTURE(first_rule);
        CAPTURE(first_conditions);
        CHECK(broken == 0);
    }
}

TEST_CASE("supervisor: a fault is left only by reset, at rest, with every trouble over")
{
    CHECK(step(SUPERVISOR_FAULT, healthy | CONDITION_REQUEST_RESET) == start);
    CHECK(step(SUPERVISOR_FAULT, (healthy | CONDITION_REQUEST_RESET) & ~CONDITION_AT_REST) == faulty_before);
    for (std::uint32_t bit = 0; bit < condition_bits; bit++) {
        CAPTURE(bit);
        if (trouble & 1u << bit) {
            CHECK(step(SUPERVISOR_FAULT, healthy | CONDITION_REQUEST_RESET | 1u << bit) == faulty_before);
        }
    }
}

TEST_CASE("supervisor: a robot that does not follow yet is waited for")
{
    CHECK(step(SUPERVISOR_READY, (healthy | CONDITION_REQUEST_RUN) & ~CONDITION_ROBOT_FOLLOWS) == ready);
    CHECK(step(SUPERVISOR_READY, healthy | CONDITION_REQUEST_RUN) == running);
}

TEST_CASE("supervisor: a condition that lasts is looked at again when another comes")
{
    supervisor supervisor;
    supervisor_start(&supervisor);
    for (int i = 0; i < 3; i++) {
        supervisor_step(&supervisor, 0);
        CHECK(supervisor.state == SUPERVISOR_START);
    }
    supervisor_step(&supervisor, healthy);
    CHECK(supervisor.state == SUPERVISOR_READY);
    supervisor_step(&supervisor, healthy);
    supervisor_step(&supervisor, healthy);
    CHECK(supervisor.state == SUPERVISOR_READY);
    /* The same conditions again after another transition: ready settled on `healthy`, holding has not. */
    supervisor_step(&supervisor, healthy & ~CONDITION_SENSOR_FRESH);
    CHECK(supervisor.state == SUPERVISOR_HOLDING);
    supervisor_step(&supervisor, healthy);
    CHECK(supervisor.state == SUPERVISOR_READY);
}

TEST_CASE("supervisor: the robot may move in running and nowhere else")
{
    for (int state = 0; state < SUPERVISOR_STATE_COUNT; state++) {
        CAPTURE(state);
        supervisor supervisor;
        supervisor_start(&supervisor);
        supervisor.state = static_cast<supervisor_state>(state);
        CHECK((supervisor_may_move(&supervisor) != 0) == (state == SUPERVISOR_RUNNING));
    }
}

TEST_CASE("supervisor: every state and every cause has a name of its own")
{
    std::set<std::string> states, causes;
    for (int i = 0; i < SUPERVISOR_STATE_COUNT; i++) {
        const char *name = supervisor_state_name(static_cast<supervisor_state>(i));
        REQUIRE(name != nullptr);
        states.insert(name);
    }
    for (int i = 0; i < STOP_CAUSE_COUNT; i++) {
        const char *name = stop_cause_name(static_cast<stop_cause>(i));
        REQUIRE(name != nullptr);
        causes.insert(name);
    }
    CHECK(states.size() == SUPERVISOR_STATE_COUNT);
    CHECK(causes.size() == STOP_CAUSE_COUNT);
    CHECK(states.count("unknown") == 0);
    CHECK(causes.count("unknown") == 0);
    CHECK(std::string(supervisor_state_name(SUPERVISOR_STATE_COUNT)) == "unknown");
    CHECK(std::string(stop_cause_name(STOP_CAUSE_COUNT)) == "unknown");
}
