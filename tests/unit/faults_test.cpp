/* What goes wrong outside, at the level of app_step: which state it leads to, why, when, and the way back. */
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fault_bench.h"

namespace
{

using bench::app_bench;
using bench::change;
using bench::check_led_to_rest;
using bench::running_bench;

/* Applies a change to every frame of one identifier. */
change frames(std::uint32_t id, const std::function<void(hal_frame &)> &apply)
{
    return [=](app_bench &bench) {
        bench.corrupt = [=](hal_frame &frame) {
            if (frame.id == id) {
                apply(frame);
            }
        };
    };
}

void shorten(hal_frame &frame)
{
    frame.length = 7;
}

void lengthen(hal_frame &frame)
{
    frame.length = 9;
}

void move_to_other_bus(hal_frame &frame)
{
    frame.bus ^= 1;
}

/* The counter, and what shares its byte, stays as it is in the first frame from now on. */
change counter_stands_still(std::uint32_t id)
{
    return [=](app_bench &bench) {
        const auto first = std::make_shared<int>(-1);
        frames(id, [=](hal_frame &frame) {
            *first = *first < 0 ? frame.data[7] : *first;
            frame.data[7] = static_cast<std::uint8_t>(*first);
        })(bench);
    };
}

hal_frame error_frame(int flags)
{
    hal_frame frame = bench::frame_of(0, HAL_BUS_ROBOT, 0);
    frame.flags = static_cast<std::uint8_t>(flags);
    return frame;
}

struct fault_case {
    const char *name;
    change spoil;
    supervisor_state state;
    stop_cause cause;
    int after_ticks; /* from the first spoilt tick to the tick that changes the state, that tick included */
};

/* The newest good frame is one tick old in the first spoilt tick; it may be stale_after_ms old and not more. */
constexpr int sensor_stale_ticks = 20 + 1;   /* 50 ms */
constexpr int feedback_stale_ticks = 40 + 1; /* 100 ms */
constexpr int operator_stale_ticks = 80 + 1; /* 200 ms */

/* The first of the frames whose counter stands still is taken. */
constexpr int one_more = 1;

constexpr auto force_id = BERTH_CAN_FORCE_FRAME_ID;
constexpr auto feedback_id = BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID;
constexpr auto motion_id = BERTH_CAN_OPERATOR_MOTION_FRAME_ID;

const std::vector<fault_case> holding_cases = {
    {"force silent", [](app_bench &b) { b.has_force = false; }, SUPERVISOR_HOLDING, STOP_SENSOR_STALE,
     sensor_stale_ticks},
    {"force frames too short", frames(force_id, shorten), SUPERVISOR_HOLDING, STOP_SENSOR_STALE, sensor_stale_ticks},
    {"force frames too long", frames(force_id, lengthen), SUPERVISOR_HOLDING, STOP_SENSOR_STALE, sensor_stale_ticks},
    {"force on the robot's bus", frames(force_id, move_to_other_bus), SUPERVISOR_HOLDING, STOP_SENSOR_STALE,
     sensor_stale_ticks},
    {"force under another identifier", frames(force_id, [](hal_frame &f) { f.id = 0x41; }), SUPERVISOR_HOLDING,
     STOP_SENSOR_STALE, sensor_stale_ticks},
    {"force counter repeated", counter_stands_still(force_id), SUPERVISOR_HOLDING, STOP_SENSOR_STALE,
     sensor_stale_ticks + one_more},
    {"force outside the frame's range", [](app_bench &b) { b.force_N = 54001.0; }, SUPERVISOR_HOLDING,
     STOP_SENSOR_STALE, sensor_stale_ticks},
    {"operator silent", [](app_bench &b) { b.has_operator = false; }, SUPERVISOR_HOLDING, STOP_OPERATOR_STALE,
     operator_stale_ticks},
    {"operator frames too short", frames(motion_id, shorten), SUPERVISOR_HOLDING, STOP_OPERATOR_STALE,
     operator_stale_ticks},
    {"operator counter repeated", counter_stands_still(motion_id), SUPERVISOR_HOLDING, STOP_OPERATOR_STALE,
     operator_stale_ticks + one_more},
    {"operator position out of range", [](app_bench &b) { b.operator_position_m = 2.05; }, SUPERVISOR_HOLDING,
     STOP_OPERATOR_STALE, operator_stale_ticks},
    {"operator request unknown", [](app_bench &b) { b.request = OPERATOR_REQUEST_COUNT; }, SUPERVISOR_HOLDING,
     STOP_OPERATOR_STALE, operator_stale_ticks},
    {"operator speaks the other interface", frames(motion_id, [](hal_frame &f) { f.id = 0x31; }), SUPERVISOR_HOLDING,
     STOP_OPERATOR_STALE, operator_stale_ticks},
    {"enable off", [](app_bench &b) { b.enable = 0; }, SUPERVISOR_HOLDING, STOP_ENABLE_OFF, 1},
    {"operator asks to hold", [](app_bench &b) { b.request = OPERATOR_HOLD; }, SUPERVISOR_HOLDING, STOP_REQUESTED,
     1},
};

const std::vector<fault_case> fault_cases = {
    {"feedback silent", [](app_bench &b) { b.has_feedback = false; }, SUPERVISOR_FAULT, STOP_FEEDBACK_STALE,
     feedback_stale_ticks},
    {"feedback frames too short", frames(feedback_id, shorten), SUPERVISOR_FAULT, STOP_FEEDBACK_STALE,
     feedback_stale_ticks},
    {"feedback counter repeated", counter_stands_still(feedback_id), SUPERVISOR_FAULT, STOP_FEEDBACK_STALE,
     feedback_stale_ticks + one_more},
    {"feedback on the sensor's bus", frames(feedback_id, move_to_other_bus), SUPERVISOR_FAULT, STOP_FEEDBACK_STALE,
     feedback_stale_ticks},
    {"robot reports a fault", [](app_bench &b) { b.robot_fault = true; }, SUPERVISOR_FAULT, STOP_ROBOT_FAULT, 1},
    {"emergency stop", [](app_bench &b) { b.emergency_stop = 1; }, SUPERVISOR_FAULT, STOP_EMERGENCY_STOP, 1},
    {"sensor saturated", [](app_bench &b) { b.saturated = true; }, SUPERVISOR_FAULT, STOP_SENSOR_SATURATED, 1},
    {"force above the limit", [](app_bench &b) { b.force_N = 20000.1; }, SUPERVISOR_FAULT, STOP_FORCE_LIMIT, 1},
    {"force below the limit", [](app_bench &b) { b.force_N = -20000.1; }, SUPERVISOR_FAULT, STOP_FORCE_LIMIT, 1},
    {"bus-off", [](app_bench &b) { b.extra = {error_frame(HAL_FRAME_ERROR | HAL_FRAME_BUS_OFF)}; }, SUPERVISOR_FAULT,
     STOP_BUS_OFF, 1},
    {"missed ticks over the budget of 25 ms", [](app_bench &b) { b.missed = 4; }, SUPERVISOR_FAULT,
     STOP_MISSED_TICKS, 3},
    {"50 ms missed at once", [](app_bench &b) { b.missed = 20; }, SUPERVISOR_FAULT, STOP_MISSED_TICKS, 1},
};

void check_led_to(app_bench &bench, const fault_case &expected)
{
    expected.spoil(bench);
    int ticks = 0;
    while (bench.state() == SUPERVISOR_RUNNING && ticks < 400) {
        bench.tick();
        ticks++;
    }
    CHECK(std::string(supervisor_state_name(bench.state())) == std::string(supervisor_state_name(expected.state)));
    CHECK(std::string(stop_cause_name(bench.cause())) == std::string(stop_cause_name(expected.cause)));
    CHECK(ticks == expected.after_ticks);
    CHECK(bench.out().fault == (expected.state == SUPERVISOR_FAULT));
    CHECK(bench.app().recorder.tick.state == expected.state);
    CHECK(bench.app().recorder.tick.stop_cause == expected.cause);
}

/* Everything as it should be again, but for what the operator wants. */
void repair(app_bench &bench)
{
    bench.corrupt = nullptr;
    bench.extra.clear();
    bench.has_force = bench.has_feedback = bench.has_operator = true;
    bench.force_N = bench.operator_position_m = 0.0;
    bench.enable = 1;
    bench.emergency_stop = 0;
    bench.robot_fault = bench.saturated = false;
    bench.missed = 0;
}

app_bench stopped_bench(const fault_case &expected)
{
    app_bench bench = running_bench();
    check_led_to(bench, expected);
    return bench;
}

} // namespace

TEST_CASE("faults: what may pass leads to holding, at its tick, under its name, and to rest")
{
    for (const fault_case &expected : holding_cases) {
        CAPTURE(std::string(expected.name));
        app_bench bench = stopped_bench(expected);
        check_led_to_rest(bench, expected.state, expected.cause);
    }
}

TEST_CASE("faults: what needs a person leads to fault, at its tick, under its name, and to rest")
{
    for (const fault_case &expected : fault_cases) {
        CAPTURE(std::string(expected.name));
        app_bench bench = stopped_bench(expected);
        check_led_to_rest(bench, expected.state, expected.cause);
    }
}

TEST_CASE("faults: holding is left for ready only after the run request is withdrawn and the enable given anew")
{
    for (const fault_case &expected : holding_cases) {
        CAPTURE(std::string(expected.name));
        app_bench bench = stopped_bench(expected);
        repair(bench);
        bench.request = OPERATOR_RUN;
        bench.run(200);
        CHECK(bench.state() == SUPERVISOR_HOLDING);
        CHECK(bench.cause() == expected.cause);
        bench.request = OPERATOR_NONE;
        bench.run(200);
        CHECK(bench.state() == SUPERVISOR_HOLDING);
        bench.enable_anew();
        CHECK(bench.state() == SUPERVISOR_READY);
        CHECK(bench.cause() == STOP_NONE);
        bench.request = OPERATOR_RUN;
        bench.run(2);
        CHECK(bench.state() == SUPERVISOR_RUNNING);
    }
}

TEST_CASE("faults: a fault is left for start only by a reset after it is over")
{
    for (const fault_case &expected : fault_cases) {
        CAPTURE(std::string(expected.name));
        app_bench bench = stopped_bench(expected);
        repair(bench);
        for (const int request : {OPERATOR_RUN, OPERATOR_NONE, OPERATOR_HOLD}) {
            bench.request = request;
            bench.run(50);
            CHECK(bench.state() == SUPERVISOR_FAULT);
            CHECK(bench.cause() == expected.cause);
        }
        bench.request = OPERATOR_RESET;
        bench.tick();
        CHECK(bench.state() == SUPERVISOR_START);
        CHECK(bench.out().fault == 0);
        bench.request = OPERATOR_NONE;
        bench.enable_anew();
        CHECK(bench.run_until(SUPERVISOR_READY));
        bench.request = OPERATOR_RUN;
        bench.run(3);
        CHECK(bench.state() == SUPERVISOR_RUNNING);
    }
}

TEST_CASE("faults: a reset while the trouble lasts changes nothing")
{
    for (const fault_case &expected : fault_cases) {
        const bool lasts = expected.cause != STOP_FEEDBACK_STALE && expected.cause != STOP_MISSED_TICKS;
        if (!lasts) {
            continue; /* start waits for feedback, and counts missed ticks afresh */
        }
        CAPTURE(std::string(expected.name));
        app_bench bench = stopped_bench(expected);
        bench.request = OPERATOR_RESET;
        bench.run(100);
        CHECK(bench.state() == SUPERVISOR_FAULT);
        CHECK(bench.cause() == expected.cause);
    }
    app_bench bench = stopped_bench(fault_cases[0]); /* feedback silent */
    bench.tick();
    bench.request = OPERATOR_RESET;
    bench.run(100);
    CHECK(bench.state() == SUPERVISOR_START);
}

TEST_CASE("faults: what is only counted does not stop the loop")
{
    const struct {
        const char *name;
        change spoil;
        std::uint32_t reception_counts::*count;
        std::uint32_t in_100_ticks;
    } rows[] = {
        {"unknown identifier", [](app_bench &b) { b.extra = {bench::frame_of(0x7ff, HAL_BUS_ROBOT, 0)}; },
         &reception_counts::unknown, 100},
        {"force frame too short beside a good one",
         [](app_bench &b) {
             b.extra = {bench::force_frame(9.0, 0)};
             b.extra[0].length = 3;
         },
         &reception_counts::wrong_length, 100},
        {"every force frame twice",
         [](app_bench &b) {
             b.extra = {bench::force_frame(9.0, 0)};
             b.corrupt = [&b](hal_frame &frame) {
                 if (frame.id == force_id) {
                     frame.data[7] = static_cast<std::uint8_t>(b.force_counter - 1);
                 }
             };
         },
         &reception_counts::repeated, 100},
        {"feedback from the past", [](app_bench &b) { b.extra = {bench::feedback_frame(0.3, 0)}; },
         &reception_counts::old, 100},
        {"two force frames of three lost",
         [](app_bench &b) {
             b.corrupt = [last = b.force_counter](hal_frame &frame) mutable {
                 if (frame.id == force_id) {
                     frame.data[7] = last = static_cast<std::uint8_t>(last + 3);
                 }
             };
         },
         &reception_counts::lost, 2 * 99},
        {"error frame", [](app_bench &b) { b.extra = {error_frame(HAL_FRAME_ERROR)}; },
         &reception_counts::error_frames, 100},
    };
    for (const auto &row : rows) {
        CAPTURE(std::string(row.name));
        app_bench bench = running_bench();
        row.spoil(bench);
        const std::uint32_t before = bench.app().reception.counts.*row.count;
        bench.tick();
        const std::uint32_t first = bench.app().reception.counts.*row.count - before;
        bench.run(99);
        CHECK(bench.state() == SUPERVISOR_RUNNING);
        const std::uint32_t counted = bench.app().reception.counts.*row.count - before;
        /* A jump of the counter when the loss begins is of any size. */
        CHECK((row.count == &reception_counts::lost ? counted - first : counted) == row.in_100_ticks);
    }
}

TEST_CASE("faults: a position from the past is not taken, though it comes last")
{
    app_bench bench = running_bench();
    for (int i = 0; i < 20; i++) {
        const std::int64_t stamp_ns = bench.now_ns() - 12500000;
        const auto counter = static_cast<std::uint8_t>(bench.feedback_counter - 6);
        bench.extra = {bench::feedback_frame(bench.robot_position_m + 0.29, counter, stamp_ns)};
        const double reported_m = bench.robot_position_m;
        bench.tick();
        CHECK(std::fabs(bench.app().recorder.tick.robot_position_m - reported_m) < 1e-9);
    }
    CHECK(bench.app().reception.counts.old == 20);
    CHECK(bench.app().recorder.tick.rejected_frames == 20);
}

TEST_CASE("faults: missed ticks up to the budget are recorded and do not stop the loop")
{
    app_bench bench = running_bench();
    bench.missed = 5;
    bench.run(2);
    CHECK(bench.app().missed_ticks == 10);
    bench.missed = 0;
    bench.run(100);
    CHECK(bench.state() == SUPERVISOR_RUNNING);
    bench.missed = 1;
    bench.tick();
    CHECK(bench.state() == SUPERVISOR_FAULT);
    CHECK(bench.cause() == STOP_MISSED_TICKS);
}
