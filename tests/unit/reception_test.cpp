#include <algorithm>
#include <doctest/doctest.h>

#include <set>
#include <string>
#include <vector>

#include "firmware/reception.h"
#include "tick_builder.h"

namespace
{

reception started()
{
    reception reception;
    const app_config config = config_default();
    reception_start(&reception, &config);
    reception_begin_tick(&reception, 0, 0);
    return reception;
}

/* Checks, and takes if it passes: as the app does with a frame whose signals are in range. */
bool take(reception &reception, const hal_frame &frame)
{
    const received_message message = reception_check(&reception, &frame);
    if (message == RECEIVED_NONE) {
        return false;
    }
    reception_accept(&reception, message, &frame);
    return true;
}

std::uint32_t rejected(const reception &reception)
{
    const reception_counts &counts = reception.counts;
    return counts.unknown + counts.wrong_length + counts.repeated + counts.old + counts.out_of_range;
}

} // namespace

/* A frame that a drive with the number 5 sends. */
hal_frame drive_frame(std::uint32_t id, std::uint8_t length)
{
    hal_frame frame = bench::frame_of(id + 5, HAL_BUS_ROBOT, 0);
    frame.length = length;
    return frame;
}

reception started_with_drive()
{
    app_config config = config_default();
    config.robot_channel.profile = ROBOT_PROFILE_CIA402;
    config.cia402.node_id = 5;
    reception reception;
    reception_start(&reception, &config);
    return reception;
}

reception started_with_arm()
{
    app_config config = config_default();
    config.arm.kind = ARM_PLANAR;
    reception reception;
    reception_start(&reception, &config);
    return reception;
}

/* Whose operator sits on the sensor's bus. */
reception started_with_station_on_sensor_bus()
{
    app_config config = config_default();
    config.arm.kind = ARM_PLANAR;
    config.operator_command.bus = HAL_BUS_SENSOR;
    reception reception;
    reception_start(&reception, &config);
    return reception;
}

reception started_with_axes()
{
    app_config config = config_default();
    config.arm.kind = ARM_PLANAR;
    for (side_axis_config &axis : config.side_axes) {
        axis.enabled = 1;
    }
    reception reception;
    reception_start(&reception, &config);
    return reception;
}

struct table_row {
    received_message message;
    hal_frame frame;
};

const std::vector<table_row> dbc_rows = {
    {RECEIVED_ROBOT_FEEDBACK, bench::feedback_frame(0.0, 1)},
    {RECEIVED_OPERATOR_MOTION, bench::motion_frame(0.0, 0.0, 0, 1)},
    {RECEIVED_OPERATOR_FORCE, bench::operator_force_frame(0.0, 0, 1)},
    {RECEIVED_FORCE, bench::force_frame(0.0, 1)},
};

const std::vector<table_row> drive_rows = {
    {RECEIVED_DRIVE_STATUS, drive_frame(0x180, 6)},
    {RECEIVED_DRIVE_HEARTBEAT, drive_frame(0x700, 1)},
    {RECEIVED_DRIVE_EMERGENCY, drive_frame(0x080, 8)},
    {RECEIVED_SDO_ANSWER, drive_frame(0x580, 8)},
    {RECEIVED_OPERATOR_MOTION, bench::motion_frame(0.0, 0.0, 0, 1)},
    {RECEIVED_OPERATOR_FORCE, bench::operator_force_frame(0.0, 0, 1)},
    {RECEIVED_FORCE, bench::force_frame(0.0, 1)},
};

const std::vector<table_row> arm_rows = {
    {RECEIVED_ROBOT_FEEDBACK, bench::feedback_frame(0.0, 1)},
    {RECEIVED_OPERATOR_MOTION, bench::motion_frame(0.0, 0.0, 0, 1)},
    {RECEIVED_OPERATOR_FORCE, bench::operator_force_frame(0.0, 0, 1)},
    {RECEIVED_OPERATOR_JOINT, bench::joint_frame(1, BERTH_CAN_OPERATOR_JOINT_ORDER_MOVE_CHOICE, 0.0, 0.0, 1)},
    {RECEIVED_OPERATOR_LINE, bench::line_frame(0.0, 0.0, 0.1, 1)},
    {RECEIVED_FORCE, bench::force_frame(0.0, 1)},
};

std::vector<table_row> with_station_on_sensor_bus(std::vector<table_row> rows)
{
    for (table_row &row : rows) {
        if (row.message >= RECEIVED_OPERATOR_MOTION && row.message <= RECEIVED_OPERATOR_LINE) {
            row.frame.bus = HAL_BUS_SENSOR;
        }
    }
    return rows;
}

const std::vector<table_row> station_rows = with_station_on_sensor_bus(arm_rows);

hal_frame side_frame(std::uint32_t id)
{
    hal_frame frame = bench::feedback_frame(0.0, 1);
    frame.id = id;
    return frame;
}

const std::vector<table_row> pose_rows = {
    {RECEIVED_ROBOT_FEEDBACK, bench::feedback_frame(0.0, 1)},
    {RECEIVED_OPERATOR_MOTION, bench::motion_frame(0.0, 0.0, 0, 1)},
    {RECEIVED_OPERATOR_FORCE, bench::operator_force_frame(0.0, 0, 1)},
    {RECEIVED_OPERATOR_JOINT, bench::joint_frame(1, BERTH_CAN_OPERATOR_JOINT_ORDER_MOVE_CHOICE, 0.0, 0.0, 1)},
    {RECEIVED_OPERATOR_LINE, bench::line_frame(0.0, 0.0, 0.1, 1)},
    {RECEIVED_FEEDBACK_Y, side_frame(BERTH_CAN_FEEDBACK_Y_FRAME_ID)},
    {RECEIVED_FEEDBACK_Z, side_frame(BERTH_CAN_FEEDBACK_Z_FRAME_ID)},
    {RECEIVED_FEEDBACK_RX, side_frame(BERTH_CAN_FEEDBACK_RX_FRAME_ID)},
    {RECEIVED_FEEDBACK_RY, side_frame(BERTH_CAN_FEEDBACK_RY_FRAME_ID)},
    {RECEIVED_FEEDBACK_RZ, side_frame(BERTH_CAN_FEEDBACK_RZ_FRAME_ID)},
    {RECEIVED_FORCE, bench::force_frame(0.0, 1)},
};

struct table {
    const std::vector<table_row> &rows;
    reception (*start)();
};
const table tables[] = {{dbc_rows, [] { return started(); }},
                        {drive_rows, started_with_drive},
                        {arm_rows, started_with_arm},
                        {station_rows, started_with_station_on_sensor_bus},
                        {pose_rows, started_with_axes}};

TEST_CASE("reception: every row takes its frame, on its bus and nowhere else")
{
    std::set<received_message> messages;
    for (const table &table : tables) {
        for (const table_row &row : table.rows) {
            CAPTURE(row.message);
            reception reception = table.start();
            CHECK(reception_check(&reception, &row.frame) == row.message);
            hal_frame elsewhere = row.frame;
            elsewhere.bus ^= 1;
            CHECK(reception_check(&reception, &elsewhere) == RECEIVED_NONE);
            CHECK(reception.counts.unknown == 1);
            messages.insert(row.message);
        }
    }
    CHECK(messages.size() == RECEIVED_FORCE + 1); /* of the sensor one frame */
}

TEST_CASE("reception: of all 11-bit identifiers only the table's of the profile are known")
{
    for (const table &table : tables) {
        reception reception = table.start();
        const std::size_t rows = table.rows.size();
        std::size_t known = 0;
        for (std::uint32_t id = 0; id < 2048; id++) {
            for (const hal_bus bus : {HAL_BUS_ROBOT, HAL_BUS_SENSOR}) {
                const hal_frame frame = bench::frame_of(id, bus, 0);
                const std::uint32_t unknown = reception.counts.unknown;
                reception_check(&reception, &frame);
                known += reception.counts.unknown == unknown;
            }
        }
        CHECK(known == rows);
        CHECK(reception.counts.unknown == std::size_t{2} * 2048 - rows);
    }
}

TEST_CASE("reception: a drive's frames have no counter, and the same one may come again")
{
    reception reception = started_with_drive();
    for (int i = 0; i < 3; i++) {
        reception_begin_tick(&reception, 0, 0);
        for (const table_row &row : drive_rows) {
            if (row.message < RECEIVED_OPERATOR_MOTION) {
                CHECK(reception_check(&reception, &row.frame) == row.message);
                reception_accept(&reception, row.message, &row.frame);
            }
        }
    }
    CHECK(reception.counts.lost == 0);
    CHECK(reception.counts.repeated == 0);
    CHECK(reception.counts.too_frequent == 0);
}

TEST_CASE("reception: a frame of any other length than its row's is rejected and counted")
{
    for (unsigned length = 0; length <= 255; length++) {
        CAPTURE(length);
        reception reception = started();
        hal_frame frame = bench::force_frame(1.0, 1);
        frame.length = static_cast<std::uint8_t>(length);
        CHECK(take(reception, frame) == (length == 8));
        CHECK(reception.counts.wrong_length == (length == 8 ? 0 : 1));
    }
}

TEST_CASE("reception: a repeated counter is rejected, a skipped one counts as lost frames")
{
    reception reception = started();
    CHECK(take(reception, bench::force_frame(1.0, 7)));
    CHECK(reception.counts.lost == 0); /* the first counter may be any */
    CHECK_FALSE(take(reception, bench::force_frame(2.0, 7)));
    CHECK(reception.counts.repeated == 1);
    CHECK(take(reception, bench::force_frame(3.0, 8)));
    CHECK(reception.counts.lost == 0);
    CHECK(take(reception, bench::force_frame(4.0, 12)));
    CHECK(reception.counts.lost == 3);
    CHECK(reception.counts.accepted == 3);
    CHECK(rejected(reception) == 1);
}

TEST_CASE("reception: counters of 8 and of 4 bits wrap around without a loss")
{
    reception reception = started();
    for (int i = 0; i < 1000; i++) {
        REQUIRE(take(reception, bench::feedback_frame(0.0, static_cast<std::uint8_t>(i))));
        REQUIRE(take(reception, bench::motion_frame(0.0, 0.0, i % 4, static_cast<std::uint8_t>(i % 16))));
    }
    CHECK(reception.counts.lost == 0);
    CHECK(rejected(reception) == 0);
    CHECK(take(reception, bench::motion_frame(0.0, 0.0, 0, 1000 % 16 + 2))); /* 8, 9 are missing */
    CHECK(reception.counts.lost == 2);
    CHECK(take(reception, bench::motion_frame(0.0, 0.0, 0, 14))); /* 11, 12, 13 */
    CHECK(reception.counts.lost == 5);
    CHECK(take(reception, bench::motion_frame(0.0, 0.0, 0, 1))); /* 15, 0: across the wrap-around */
    CHECK(reception.counts.lost == 7);
    CHECK(take(reception, bench::feedback_frame(0.0, 254))); /* after 231: 232 to 253 */
    CHECK(take(reception, bench::feedback_frame(0.0, 1)));   /* 255, 0 */
    CHECK(reception.counts.lost == 7 + 22 + 2);
}

TEST_CASE("reception: the 4-bit counter is apart from the request beside it")
{
    reception reception = started();
    CHECK(take(reception, bench::motion_frame(0.0, 0.0, OPERATOR_HOLD, 3)));
    CHECK_FALSE(take(reception, bench::motion_frame(0.0, 0.0, OPERATOR_RUN, 3)));
    CHECK(take(reception, bench::motion_frame(0.0, 0.0, OPERATOR_HOLD, 4)));
}

TEST_CASE("reception: counters of different messages do not touch each other")
{
    reception reception = started();
    CHECK(take(reception, bench::feedback_frame(0.0, 9)));
    CHECK(take(reception, bench::force_frame(0.0, 9)));
    CHECK(take(reception, bench::motion_frame(0.0, 0.0, 0, 9)));
    CHECK(take(reception, bench::operator_force_frame(0.0, 0, 9)));
}

TEST_CASE("reception: a message is stale before its first frame and once its row's age is exceeded")
{
    const struct {
        received_message message;
        double stale_after_ms;
        hal_frame frame;
    } rows[] = {
        {RECEIVED_ROBOT_FEEDBACK, 30.0, bench::feedback_frame(0.0, 1, 1000)},
        {RECEIVED_OPERATOR_MOTION, 40.0, bench::motion_frame(0.0, 0.0, 0, 1, 1000)},
        {RECEIVED_OPERATOR_FORCE, 40.0, bench::operator_force_frame(0.0, 0, 1, 1000)},
        {RECEIVED_FORCE, 20.0, bench::force_frame(0.0, 1, 1000)},
    };
    app_config config = config_default();
    config.robot_channel.stale_after_ms = 30.0;
    config.operator_command.stale_after_ms = 40.0;
    config.sensor_channel.stale_after_ms = 20.0;
    reception reception;
    reception_start(&reception, &config);
    for (const auto &row : rows) {
        CAPTURE(row.message);
        const std::int64_t age_ns = ns_from_ms(row.stale_after_ms);
        CHECK(reception_is_stale(&reception, row.message, 0));
        reception_begin_tick(&reception, 0, 1000);
        CHECK(take(reception, row.frame));
        CHECK_FALSE(reception_is_stale(&reception, row.message, 1000));
        CHECK_FALSE(reception_is_stale(&reception, row.message, 1000 + age_ns));
        CHECK(reception_is_stale(&reception, row.message, 1001 + age_ns));
    }
}

TEST_CASE("reception: a rejected frame does not refresh the age of its message")
{
    reception reception = started();
    CHECK(take(reception, bench::force_frame(0.0, 1, 0)));
    reception_begin_tick(&reception, 0, 60000000);
    CHECK_FALSE(take(reception, bench::force_frame(0.0, 1, 60000000)));
    CHECK(reception_is_stale(&reception, RECEIVED_FORCE, 60000000));
    const hal_frame out_of_range = bench::force_frame(0.0, 2, 60000000);
    CHECK(reception_check(&reception, &out_of_range) == RECEIVED_FORCE);
    reception_reject_range(&reception);
    CHECK(reception.counts.out_of_range == 1);
    CHECK(reception_is_stale(&reception, RECEIVED_FORCE, 60000000));
    CHECK(take(reception, bench::force_frame(0.0, 3, 60000000)));
    CHECK(reception.counts.lost == 1); /* the one out of range carried nothing */
}

TEST_CASE("reception: error frames are counted, a bus-off holds for its tick, their data are no signal")
{
    reception reception = started();
    hal_frame frame = bench::force_frame(1.0, 1);
    frame.flags = HAL_FRAME_ERROR;
    CHECK_FALSE(take(reception, frame));
    CHECK(reception.counts.error_frames == 1);
    CHECK(reception.bus_off == 0);
    frame.flags = HAL_FRAME_ERROR | HAL_FRAME_BUS_OFF;
    CHECK_FALSE(take(reception, frame));
    CHECK(reception.bus_off == 1);
    frame.flags = HAL_FRAME_ERROR;
    CHECK_FALSE(take(reception, frame)); /* a later error frame of the same tick does not take it back */
    CHECK(reception.bus_off == 1);
    reception_begin_tick(&reception, 0, 0);
    CHECK(reception.bus_off == 0);
    CHECK(reception.counts.error_frames == 3);
    CHECK(reception_is_stale(&reception, RECEIVED_FORCE, 0));
}

TEST_CASE(
    "reception: more frames than belong to the time since the last tick are counted, and the newest still counts")
{
    reception reception = started();
    const auto take_force_frames = [&](std::uint32_t missed_ticks, int first, int count) {
        reception_begin_tick(&reception, missed_ticks, 100000);
        for (int i = 0; i < count; i++) {
            hal_frame frame = bench::force_frame(1.0, first + i);
            frame.time_ns = std::int64_t{1000} * (first + i);
            CHECK(take(reception, frame));
        }
        return reception.counts.too_frequent;
    };
    CHECK(take_force_frames(0, 0, 2) == 0); /* one held up by the bus comes together with its successor */
    CHECK(take_force_frames(0, 2, 5) == 3);
    CHECK(take_force_frames(3, 7, 5) == 3); /* four periods have passed: five frames are no flood */
    CHECK(take_force_frames(3, 12, 6) == 4);
    CHECK(reception.messages[RECEIVED_FORCE].received_ns == 17000);
}

namespace
{

constexpr std::int64_t ms = 1000000;

/* One frame is taken at 200 ms; the second comes in a tick at `now_ns`. */
struct old_frame_case {
    const char *name;
    hal_frame first, second;
    std::int64_t now_ns;
    bool is_taken;
};

hal_frame feedback(int counter, std::int64_t time_ns)
{
    return bench::feedback_frame(0.0, static_cast<std::uint8_t>(counter), time_ns);
}

hal_frame command(int counter, std::int64_t time_ns)
{
    return bench::motion_frame(0.0, 0.0, 0, static_cast<std::uint8_t>(counter), time_ns);
}

/* Feedback is stale after 100 ms, a command after 200 ms. */
const old_frame_case old_frames[] = {
    {"the next one", feedback(7, 200 * ms), feedback(8, 202 * ms), 202 * ms, true},
    {"of the same instant", feedback(7, 200 * ms), feedback(8, 200 * ms), 202 * ms, true},
    {"stamped before the newest one", feedback(7, 200 * ms), feedback(8, 200 * ms - 1), 202 * ms, false},
    {"as old as may be", feedback(7, 200 * ms), feedback(8, 200 * ms), 300 * ms, true},
    {"older than may be", feedback(7, 200 * ms), feedback(8, 200 * ms), 300 * ms + 1, false},
    {"counter one step back", feedback(7, 200 * ms), feedback(6, 202 * ms), 202 * ms, false},
    {"counter six steps back, stamped in the past", feedback(7, 200 * ms), feedback(1, 190 * ms), 202 * ms, false},
    {"counter half a turn back", feedback(200, 200 * ms), feedback(73, 202 * ms), 202 * ms, false},
    {"counter half a turn ahead", feedback(200, 200 * ms), feedback(72, 202 * ms), 202 * ms, true},
    {"counter back across zero", feedback(3, 200 * ms), feedback(250, 202 * ms), 202 * ms, false},
    {"counter of a robot that began anew, before a tick saw that it was gone", feedback(100, 200 * ms),
     feedback(0, 305 * ms), 305 * ms, false},
    {"counter of a robot that began anew, afterwards", feedback(100, 200 * ms), feedback(0, 305 * ms + 1),
     305 * ms + 1, true},
    {"4 bits, half a turn back", command(9, 200 * ms), command(2, 202 * ms), 202 * ms, false},
    {"4 bits, back, in the time of half a turn", command(9, 200 * ms), command(8, 217 * ms), 217 * ms, false},
    {"4 bits, back, after more than that: as many may be lost", command(9, 200 * ms), command(8, 218 * ms), 218 * ms,
     true},
    {"4 bits, half a turn ahead", command(9, 200 * ms), command(1, 202 * ms), 202 * ms, true},
};

} // namespace

TEST_CASE("reception: a frame from the past is refused, by its stamp and by its counter, and counted")
{
    for (const old_frame_case &row : old_frames) {
        CAPTURE(std::string(row.name));
        reception reception = started();
        reception_begin_tick(&reception, 0, 200 * ms);
        REQUIRE(take(reception, row.first));
        reception_begin_tick(&reception, 0, row.now_ns);
        CHECK(take(reception, row.second) == row.is_taken);
        CHECK(reception.counts.old == (row.is_taken ? 0 : 1));
    }
}

TEST_CASE("reception: one frame of another sender does not put the sender's own frames into the past")
{
    struct follower {
        const char *name;
        int counter;
        std::int64_t time_ns;
        bool is_taken;
        std::uint32_t lost;
    };
    /* At 200 ms one with counter 7, at 201 ms one of another sender with 20, at 202.5 ms one with 8: refused. */
    const follower followers[] = {
        {"the sender's next one, a period later", 9, 205 * ms, true, 12},
        {"in the same burst", 9, 202 * ms + 600000, false, 12},
        {"with a gap", 10, 205 * ms, false, 12},
        {"the other sender's next one", 21, 205 * ms, true, 12},
    };
    for (const follower &row : followers) {
        CAPTURE(std::string(row.name));
        reception reception = started();
        reception_begin_tick(&reception, 0, 210 * ms);
        REQUIRE(take(reception, feedback(7, 200 * ms)));
        REQUIRE(take(reception, feedback(20, 201 * ms)));
        REQUIRE_FALSE(take(reception, feedback(8, 202 * ms + 500000)));
        reception_begin_tick(&reception, 0, std::max(row.time_ns, 210 * ms));
        CHECK(take(reception, feedback(row.counter, row.time_ns)) == row.is_taken);
        CHECK(reception.counts.lost == row.lost);
        CHECK(reception.counts.old == (row.is_taken ? 1 : 2));
    }
    reception reception = started();
    reception_begin_tick(&reception, 0, 310 * ms);
    for (const auto &[counter, time_ns] : {std::pair{20, 201 * ms}, {8, 203 * ms}, {21, 300 * ms}}) {
        take(reception, feedback(counter, time_ns));
    }
    CHECK_FALSE(take(reception, feedback(9, 310 * ms))); /* one so long ago is of no weight */
}

TEST_CASE("reception: a drive's frame without a counter is refused by its stamp alone")
{
    reception reception = started_with_drive();
    reception_begin_tick(&reception, 0, 200 * ms);
    hal_frame status = drive_frame(0x180, 6);
    status.time_ns = 200 * ms;
    CHECK(take(reception, status));
    CHECK(take(reception, status));
    status.time_ns -= 1;
    CHECK_FALSE(take(reception, status));
    CHECK(reception.counts.old == 1);
}

TEST_CASE("reception: a stamp from the future does not keep a message fresh, nor its successors out")
{
    reception reception = started();
    reception_begin_tick(&reception, 0, 200 * ms);
    REQUIRE(take(reception, feedback(1, 5000 * ms)));
    CHECK_FALSE(reception_is_stale(&reception, RECEIVED_ROBOT_FEEDBACK, 300 * ms));
    CHECK(reception_is_stale(&reception, RECEIVED_ROBOT_FEEDBACK, 301 * ms));
    reception_begin_tick(&reception, 0, 202 * ms);
    CHECK(take(reception, feedback(2, 202 * ms)));
}
