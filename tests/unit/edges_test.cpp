/* Enable, run and reset count only after they were seen off: what merely stands there moves nothing. */
#include <doctest/doctest.h>

#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "fault_bench.h"

namespace
{

using bench::app_bench;

constexpr std::uint32_t fresh = CONDITION_FEEDBACK_FRESH | CONDITION_SENSOR_FRESH | CONDITION_OPERATOR_FRESH;
constexpr std::uint32_t healthy = fresh | CONDITION_ROBOT_AT_PLACE | CONDITION_AT_REST | CONDITION_ROBOT_FOLLOWS;

supervisor after(supervisor from, const std::vector<std::uint32_t> &conditions)
{
    for (const std::uint32_t each : conditions) {
        supervisor_step(&from, each);
    }
    return from;
}

supervisor supervisor_at_start()
{
    supervisor supervisor;
    supervisor_start(&supervisor);
    return supervisor;
}

constexpr std::uint32_t off = healthy;
constexpr std::uint32_t on = healthy | CONDITION_ENABLE;
constexpr std::uint32_t run = on | CONDITION_REQUEST_RUN;
constexpr std::uint32_t reset = on | CONDITION_REQUEST_RESET;
constexpr std::uint32_t pressed = on | CONDITION_EMERGENCY_STOP;
constexpr std::uint32_t unwired = on | CONDITION_ENABLE_NOT_WIRED;

struct path {
    const char *name;
    std::vector<std::uint32_t> conditions;
    supervisor_state end;
};

const std::vector<path> paths = {
    {"enable off in start, then on, then run", {off, on, on, run}, SUPERVISOR_RUNNING},
    {"enable off in ready, then on, then run", {on, on, off, on, run}, SUPERVISOR_RUNNING},
    {"all of it stands there from the start", {run, run, run, run}, SUPERVISOR_READY},
    {"enable stands there from the start", {on, on, on, run}, SUPERVISOR_READY},
    {"run stands there from the start", {run & ~CONDITION_ENABLE, run, run, run}, SUPERVISOR_READY},
    {"run is asked for from the tick that makes the loop ready",
     {0, off | CONDITION_REQUEST_RUN, run, run},
     SUPERVISOR_READY},
    {"no enable line, then run", {unwired, unwired, unwired | CONDITION_REQUEST_RUN}, SUPERVISOR_RUNNING},
    {"no enable line, run stands there",
     {unwired | CONDITION_REQUEST_RUN, unwired | CONDITION_REQUEST_RUN},
     SUPERVISOR_READY},
    {"after a hold the enable stands there",
     {off, on, on, run, on | CONDITION_REQUEST_HOLD, on, on},
     SUPERVISOR_HOLDING},
    {"after a hold the enable is given anew",
     {off, on, on, run, on | CONDITION_REQUEST_HOLD, off, on},
     SUPERVISOR_READY},
    {"an enable that is off for the tick that stops only", {off, on, on, run, off, on, on}, SUPERVISOR_HOLDING},
    {"reset stands there when the fault comes",
     {off, on, pressed | CONDITION_REQUEST_RESET, reset, reset},
     SUPERVISOR_FAULT},
    {"reset is asked for in fault", {off, on, pressed, on, reset}, SUPERVISOR_START},
    {"after a reset the enable stands there", {off, on, pressed, on, reset, on, on, run}, SUPERVISOR_READY},
    {"after a reset an enable that was given anew in fault",
     {off, on, pressed, off, reset, on, on, run},
     SUPERVISOR_READY},
    {"after a reset the enable is given anew", {off, on, pressed, off, reset, on, off, on, run}, SUPERVISOR_RUNNING},
    {"enable off in holding, on in ready",
     {off, on, run & ~CONDITION_SENSOR_FRESH, off, on, on, run},
     SUPERVISOR_RUNNING},
};

/* What a bystander has seen, apart from the supervisor's own memory. */
struct bystander {
    enum class press : std::uint8_t { none, was_off, was_off_then_on };
    press enable = press::none; /* since the loop was started, or last ran, was in fault or was reset */
    press run = press::none;    /* since the loop became ready */

    static press next(press before, bool is_on)
    {
        return !is_on ? press::was_off : before == press::none ? press::none : press::was_off_then_on;
    }
    bool operator<(const bystander &other) const
    {
        return std::tie(enable, run) < std::tie(other.enable, other.run);
    }
};

using situation = std::tuple<int, int, std::uint32_t, bystander>; /* state, cause, seen_off */

/* Every condition that decides about motion alone, the others in groups that go together. */
std::vector<std::uint32_t> all_inputs()
{
    constexpr std::array bits = {std::uint32_t{CONDITION_ENABLE},
                                 std::uint32_t{CONDITION_REQUEST_RUN},
                                 std::uint32_t{CONDITION_REQUEST_RESET},
                                 std::uint32_t{CONDITION_REQUEST_HOLD},
                                 std::uint32_t{CONDITION_STOP},
                                 std::uint32_t{CONDITION_AT_REST},
                                 std::uint32_t{CONDITION_EMERGENCY_STOP},
                                 std::uint32_t{CONDITION_MISSED_TICKS},
                                 std::uint32_t{CONDITION_SENSOR_FRESH},
                                 std::uint32_t{CONDITION_FEEDBACK_FRESH | CONDITION_OPERATOR_FRESH |
                                               CONDITION_ROBOT_AT_PLACE | CONDITION_ROBOT_FOLLOWS}};
    std::vector<std::uint32_t> inputs;
    for (std::uint32_t set = 0; set < 1u << bits.size(); set++) {
        std::uint32_t input = 0;
        for (std::size_t i = 0; i < bits.size(); i++) {
            input |= set >> i & 1u ? bits[i] : 0u;
        }
        inputs.push_back(input);
    }
    return inputs;
}

} // namespace

TEST_CASE("edges: each path of presses ends in its state")
{
    for (const path &path : paths) {
        CAPTURE(std::string(path.name));
        const supervisor end = after(supervisor_at_start(), path.conditions);
        CHECK(std::string(supervisor_state_name(end.state)) == std::string(supervisor_state_name(path.end)));
    }
}

TEST_CASE("edges: in each state, what was not seen off does not count where a person has to do it anew")
{
    const std::uint32_t anew[SUPERVISOR_STATE_COUNT] = {
        0, CONDITION_ENABLE | CONDITION_REQUEST_RUN, 0, CONDITION_ENABLE, CONDITION_REQUEST_RESET, 0};
    const std::uint32_t bits[] = {CONDITION_ENABLE, CONDITION_REQUEST_RUN, CONDITION_REQUEST_RESET};
    for (int state = 0; state < SUPERVISOR_STATE_COUNT; state++) {
        for (unsigned set = 0; set < 128; set++) {
            std::uint32_t conditions = healthy, seen_off = 0;
            for (unsigned i = 0; i < 3; i++) {
                conditions |= set >> i & 1u ? bits[i] : 0u;
                seen_off |= set >> (i + 3) & 1u ? bits[i] : 0u;
            }
            const bool is_unwired = set >> 6 != 0;
            conditions |= is_unwired ? std::uint32_t{CONDITION_ENABLE_NOT_WIRED} : 0u;
            CAPTURE(state);
            CAPTURE(set);
            const std::uint32_t counting =
                supervisor_counting(static_cast<supervisor_state>(state), seen_off, conditions);
            for (const std::uint32_t bit : bits) {
                const bool is_excused = is_unwired && bit == CONDITION_ENABLE;
                const bool counts = (conditions & bit) && (!(anew[state] & bit) || (seen_off & bit) || is_excused);
                CHECK(((counting & bit) != 0) == counts);
            }
            CHECK((counting & healthy) == healthy);
        }
    }
}

TEST_CASE("edges: no path leads to running without enable seen off, then on, and run seen off in ready, then on")
{
    using press = bystander::press;
    const std::vector<std::uint32_t> inputs = all_inputs();
    std::set<situation> seen;
    std::vector<situation> next = {{SUPERVISOR_START, STOP_NONE, 0u, bystander{}}};
    int starts_to_run = 0;
    int breaches = 0;
    while (!next.empty()) {
        const auto [state, cause, seen_off, before] = next.back();
        next.pop_back();
        for (const std::uint32_t input : inputs) {
            supervisor supervisor = supervisor_at_start();
            supervisor.state = static_cast<supervisor_state>(state);
            supervisor.stop_cause = static_cast<stop_cause>(cause);
            supervisor.seen_off = seen_off;
            bystander now = before;
            now.enable = bystander::next(before.enable, (input & CONDITION_ENABLE) != 0);
            now.run = bystander::next(before.run, (input & CONDITION_REQUEST_RUN) != 0);
            supervisor_step(&supervisor, input);
            const bool has_entered = supervisor.state != state;
            if (has_entered && supervisor.state == SUPERVISOR_RUNNING) {
                starts_to_run++;
                breaches += now.enable != press::was_off_then_on || now.run != press::was_off_then_on;
            }
            if (has_entered && (state == SUPERVISOR_RUNNING || state == SUPERVISOR_FAULT ||
                                supervisor.state == SUPERVISOR_RUNNING || supervisor.state == SUPERVISOR_FAULT)) {
                now.enable = press::none;
            }
            if (has_entered) {
                now.run = press::none;
            }
            const situation reached{supervisor.state, supervisor.stop_cause, supervisor.seen_off, now};
            if (seen.insert(reached).second) {
                next.push_back(reached);
            }
        }
    }
    CHECK(starts_to_run > 0);
    CHECK(breaches == 0);
}

TEST_CASE("edges: a loop that finds a request to run when it starts does not move")
{
    for (const bool enable_stands : {true, false}) {
        CAPTURE(enable_stands);
        app_bench bench;
        bench.waits_until_ready = false;
        bench.request = OPERATOR_RUN;
        bench.enable = enable_stands ? std::uint8_t{1} : std::uint8_t{HAL_LEVEL_NOT_WIRED};
        bench.run(4000);
        CHECK(bench.state() != SUPERVISOR_RUNNING);
        CHECK(bench.app().recorder.tick.command_position_m == doctest::Approx(0.01));
        bench.request = OPERATOR_NONE;
        bench.run(2);
        bench.request = OPERATOR_RUN;
        CHECK(bench.run_until(SUPERVISOR_RUNNING));
    }
}
