/* Profile "cia402" frame by frame: what the firmware sends is held against bytes written down from CiA 301 and 402.
 * Other people's drives are in tests/python/test_canopen_peers.py. */
#include <array>
#include <cmath>
#include <set>

#include "drive_bench.h"
#include "firmware/cia402_text.h"
#include "seeded.h"

using bench::bytes;
using bench::counts_per_m;
using bench::drive_bench;
using bench::drive_config;
using bench::frame_with;
using bench::master;
using bench::node;
using bench::sdo;

TEST_CASE("cia402: the set-up, request by request")
{
    drive_bench bench;
    REQUIRE(bench.run_until(SUPERVISOR_READY));
    const std::vector<bytes> expected = {
        sdo(0x40, 0x1000, 0, 0),          /* is it a CiA 402 device */
        sdo(0x40, 0x6502, 0, 0),          /* that has the mode */
        sdo(0x2b, 0x1017, 0, 100),        /* its heartbeat in ms */
        sdo(0x23, 0x1016, 1, 0x0063012c), /* ours: node 99, 300 ms */
        sdo(0x23, 0x1006, 0, 2500),       /* SYNC period in us */
        sdo(0x23, 0x1400, 1, 0x80000205), /* receive PDO 1: off, mapping, on with every SYNC */
        sdo(0x2f, 0x1600, 0, 0),          sdo(0x23, 0x1600, 1, 0x60400010), /* controlword, 16 bits */
        sdo(0x23, 0x1600, 2, 0x607a0020),                                   /* target position, 32 bits */
        sdo(0x2f, 0x1600, 0, 2),          sdo(0x2f, 0x1400, 2, 1),          sdo(0x23, 0x1400, 1, 0x00000205),
        sdo(0x23, 0x1800, 1, 0xc0000185), /* transmit PDO 1 alike, without remote frames */
        sdo(0x2f, 0x1a00, 0, 0),          sdo(0x23, 0x1a00, 1, 0x60410010), /* statusword */
        sdo(0x23, 0x1a00, 2, 0x60640020),                                   /* position actual value */
        sdo(0x2f, 0x1a00, 0, 2),          sdo(0x2f, 0x1800, 2, 1),          sdo(0x23, 0x1800, 1, 0x40000185),
        sdo(0x2f, 0x60c2, 1, 25),                                  /* interpolation time period 25 * 10^-4 s */
        sdo(0x2f, 0x60c2, 2, 0xfc),       sdo(0x2f, 0x6060, 0, 8), /* cyclic synchronous position */
        sdo(0x40, 0x6061, 0, 0),
    };
    CHECK(bench.requests == expected);
    REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
    CHECK(bench.statusword == 0x1237);
}

TEST_CASE("cia402: the frames of a running tick")
{
    drive_bench bench;
    REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
    bench.run(100);
    const std::int64_t index = bench.app().recorder.tick.index;
    bench.run(static_cast<int>(40 - index % 40)); /* a tick with our heartbeat and our status */
    REQUIRE(bench.out.frame_count == 4);
    const hal_frame *frames = bench.out.frames;
    CHECK(frames[0].id == 0x080);
    CHECK(frames[0].length == 0);
    CHECK(frames[1].id == 0x205);
    CHECK(frames[1].length == 6);
    CHECK(frames[1].data[0] == 0x0f);
    CHECK(frames[1].data[1] == 0x00);
    std::int32_t counts;
    std::memcpy(&counts, frames[1].data + 2, 4);
    CHECK(counts == std::lround(bench.app().recorder.tick.filtered_position_m * counts_per_m));
    CHECK(bench.app().recorder.tick.command_position_m == counts / counts_per_m);
    CHECK(frames[2].id == 0x700 + master);
    CHECK(frames[2].length == 1);
    CHECK(frames[2].data[0] == 5);
    CHECK(frames[3].id == BERTH_CAN_LOOP_STATUS_FRAME_ID);
}

TEST_CASE("cia402: what may be sent, in each state of the supervisor")
{
    const auto check = [](drive_bench &bench) {
        const supervisor_state state = bench.state();
        CHECK((bench.sent(0x000) == nullptr || state == SUPERVISOR_START || state == SUPERVISOR_STOPPED));
        CHECK((bench.sent(0x600 + node) == nullptr || state == SUPERVISOR_START));
        const bool may_enable = state == SUPERVISOR_READY || state == SUPERVISOR_RUNNING ||
                                state == SUPERVISOR_HOLDING || state == SUPERVISOR_FAULT;
        CHECK((may_enable || bench.sent_controlword() == 0));
    };
    drive_bench bench;
    std::set<int> seen;
    const auto run = [&](int ticks) {
        for (int i = 0; i < ticks; i++) {
            bench.tick();
            check(bench);
            seen.insert(bench.state());
        }
    };
    run(200);
    bench.request = OPERATOR_HOLD;
    run(200);
    bench.request = OPERATOR_RUN;
    bench.emergency_stop = 1;
    run(200);
    CHECK(bench.sent_controlword() == 0x0f); /* led to rest and held */
    bench.emergency_stop = 0;
    bench.request = OPERATOR_RESET;
    run(3);
    CHECK(bench.state() == SUPERVISOR_START);
    bench.request = OPERATOR_NONE;
    run(200);
    bench.stop = 1;
    run(1);
    CHECK(seen.size() == SUPERVISOR_STATE_COUNT);
    REQUIRE(bench.state() == SUPERVISOR_STOPPED);
    /* The last words: switched off by a SYNC of this very tick, then back to where it boots. */
    REQUIRE(bench.out.frame_count >= 3);
    CHECK(bench.out.frames[0].id == 0x205);
    CHECK(bench.out.frames[1].id == 0x080);
    CHECK(bench.out.frames[2].id == 0x000);
    CHECK(bench.out.frames[2].data[0] == 0x82);
    CHECK(bench.statusword == 0x0250);
}

TEST_CASE("cia402: after a reset the drive is switched off before its communication is reset")
{
    drive_bench bench;
    REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
    bench.emergency_stop = 1;
    bench.run(400);
    bench.emergency_stop = 0;
    bench.request = OPERATOR_RESET;
    for (int i = 0; i < 400 && bench.sent(0x000) == nullptr; i++) {
        bench.tick();
        CHECK((bench.sent(0x000) == nullptr || bench.statusword == 0x0250));
    }
    CHECK(bench.sent(0x000) != nullptr);
    bench.request = OPERATOR_RUN;
    CHECK(bench.run_until(SUPERVISOR_RUNNING));
}

TEST_CASE("cia402: each trouble of the drive is a robot fault, by its name, and lasts until the reset")
{
    struct trouble_case {
        cia402_trouble trouble;
        void (*spoil)(drive_bench &);
        void (*repair)(drive_bench &);
        std::uint32_t error;
    };
    const trouble_case cases[] = {
        {DRIVE_TROUBLE_SDO_ABORT,
         [](drive_bench &b) { b.answer_instead[0x606000] = sdo(0x80, 0x6060, 0, 0x06090030); },
         [](drive_bench &b) { b.answer_instead.clear(); }, 0x06090030},
        {DRIVE_TROUBLE_UNWATCHED,
         [](drive_bench &b) { b.answer_instead[0x101601] = sdo(0x80, 0x1016, 1, 0x06020000); },
         [](drive_bench &b) { b.answer_instead.clear(); }, 0},
        {DRIVE_TROUBLE_STRANGE_ANSWER, [](drive_bench &b) { b.write_command = 0xe0; },
         [](drive_bench &b) { b.write_command = 0x60; }, 0},
        {DRIVE_TROUBLE_STRANGE_ANSWER, [](drive_bench &b) { b.read_command = 0xc3; },
         [](drive_bench &b) { b.read_command = 0; }, 0},
        {DRIVE_TROUBLE_NO_ANSWER, [](drive_bench &b) { b.answers_sdo = false; },
         [](drive_bench &b) { b.answers_sdo = true; }, 0},
        {DRIVE_TROUBLE_NOT_ENABLED, [](drive_bench &b) { b.enables = false; },
         [](drive_bench &b) { b.enables = true; }, 0},
    };
    for (const trouble_case &one : cases) {
        CAPTURE(std::string(cia402_trouble_name(one.trouble)));
        drive_bench bench;
        one.spoil(bench);
        REQUIRE(bench.run_until(SUPERVISOR_FAULT, 4000));
        CHECK(bench.cause() == STOP_ROBOT_FAULT);
        CHECK(bench.trouble() == one.trouble);
        CHECK(bench.app().recorder.tick.drive_error == one.error);
        CHECK(bench.app().recorder.tick.drive_trouble == one.trouble);
        one.repair(bench);
        bench.check_reset_brings_back();
    }
}

TEST_CASE("cia402: trouble in motion")
{
    struct trouble_case {
        cia402_trouble trouble;
        int ticks_max;
        void (*spoil)(drive_bench &);
        void (*repair)(drive_bench &);
    };
    const trouble_case cases[] = {
        {DRIVE_TROUBLE_EMERGENCY, 2,
         [](drive_bench &b) {
             b.answers.push_back(frame_with(0x080 + node, {0x11, 0x86, 0x21, 0, 0, 0, 0, 0}));
         },
         [](drive_bench &b) {
             b.answers.push_back(frame_with(0x080 + node, {0, 0, 0, 0, 0, 0, 0, 0}));
         }},
        {DRIVE_TROUBLE_HEARTBEAT, 122, [](drive_bench &b) { b.heartbeats = false; },
         [](drive_bench &b) { b.heartbeats = true; }},
        {DRIVE_TROUBLE_NOT_OPERATIONAL, 2,
         [](drive_bench &b) {
             b.answers.push_back(frame_with(0x700 + node, {0x7f}));
             b.heartbeats = false;
         },
         [](drive_bench &b) { b.heartbeats = true; }},
        {DRIVE_TROUBLE_FAULT, 3, [](drive_bench &b) { b.statusword = 0x0218; }, [](drive_bench &) {}},
        {DRIVE_TROUBLE_FAULT, 3, [](drive_bench &b) { b.statusword = 0x021f; },
         [](drive_bench &b) { b.statusword = 0x0218; }},
        {DRIVE_TROUBLE_DROPPED_OUT, 3,
         [](drive_bench &b) {
             b.enables = false;
             b.statusword = 0x0233;
         },
         [](drive_bench &b) { b.enables = true; }},
    };
    for (const trouble_case &one : cases) {
        CAPTURE(std::string(cia402_trouble_name(one.trouble)));
        drive_bench bench;
        REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
        bench.run(300);
        one.spoil(bench);
        REQUIRE(bench.run_until(SUPERVISOR_FAULT, one.ticks_max));
        CHECK(bench.cause() == STOP_ROBOT_FAULT);
        CHECK(bench.trouble() == one.trouble);
        one.repair(bench);
        bench.check_reset_brings_back();
    }
}

TEST_CASE("cia402: feedback that stays away is a fault of its own")
{
    drive_bench bench;
    REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
    bench.sends_pdos = false;
    REQUIRE(bench.run_until(SUPERVISOR_FAULT, 50));
    CHECK(bench.cause() == STOP_FEEDBACK_STALE);
}

TEST_CASE("cia402: a drive that is switched off is asked for again and again")
{
    drive_bench bench;
    bench.boots = false;
    int asked = 0;
    for (int i = 0; i < 4000; i++) { /* 10 s */
        bench.tick();
        asked += bench.sent(0x000) != nullptr;
    }
    CHECK(bench.state() == SUPERVISOR_START);
    CHECK(asked == 5); /* every 2 s */
    CHECK(bench.requests.empty());
    bench.boots = true;
    CHECK(bench.run_until(SUPERVISOR_RUNNING));
}

TEST_CASE("cia402: answers that belong to nothing are rejected")
{
    drive_bench bench;
    REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
    const std::uint32_t before = bench.app().reception.counts.out_of_range;
    bench.answers.push_back(frame_with(0x580 + node, sdo(0x60, 0x1017, 0, 0)));     /* nothing was asked */
    bench.answers.push_back(frame_with(0x700 + node, {0x33}));                      /* no NMT state */
    bench.answers.push_back(frame_with(0x180 + node, {0x37, 0x12, 0, 0, 0, 0x7f})); /* 213 m */
    bench.answers.push_back(frame_with(0x180 + node, {0x2c, 0x00, 0, 0, 0, 0}));    /* no state of a drive */
    bench.tick();
    CHECK(bench.app().reception.counts.out_of_range - before == 4);
    CHECK(bench.state() == SUPERVISOR_RUNNING);
    const std::uint32_t lengths = bench.app().reception.counts.wrong_length;
    bench.answers.push_back(frame_with(0x180 + node, {0x37, 0x12, 0, 0, 0, 0, 0, 0}));
    bench.answers.push_back(frame_with(0x080 + node, {0x37, 0x12}));
    bench.tick();
    CHECK(bench.app().reception.counts.wrong_length - lengths == 2);
    CHECK(bench.state() == SUPERVISOR_RUNNING);
}

TEST_CASE("cia402: whatever a drive says, one request at a time, and no voltage before it is ready")
{
    SEEDED(random, "cia402: whatever a drive says*");
    const auto below = [&](std::uint64_t limit) { return random() % limit; };
    drive_bench bench;
    const std::uint32_t ids[] = {0x180 + node, 0x580 + node, 0x080 + node, 0x700 + node};
    for (int i = 0; i < 20000; i++) {
        for (std::uint64_t k = below(4); k > 0; k--) {
            const std::uint32_t id = ids[below(4)];
            bytes data(id == 0x180 + node ? 6 : id == 0x700 + node ? 1 : 8);
            for (std::uint8_t &byte : data) {
                byte = static_cast<std::uint8_t>(below(3) == 0 ? below(256) : below(2) * 8);
            }
            bench.answers.push_back(frame_with(id, data));
        }
        bench.request = static_cast<int>(below(4));
        bench.tick();
        int requests = 0;
        for (std::uint32_t f = 0; f < bench.out.frame_count; f++) {
            requests += bench.out.frames[f].id == 0x600 + node;
        }
        REQUIRE(requests <= 1);
        REQUIRE(bench.out.frame_count <= TICK_FRAMES_OUT_MAX);
        REQUIRE((bench.state() != SUPERVISOR_START || bench.sent_controlword() == 0));
    }
}

TEST_CASE("cia402: the period as object 0x60C2 tells it")
{
    struct period_case {
        double rate_Hz;
        int value;
        int index;
    };
    for (const period_case &one : {period_case{400, 25, -4},
                                   {1000, 1, -3},
                                   {100, 10, -3},
                                   {50, 20, -3},
                                   {4, 250, -3},
                                   {8000, 125, -6},
                                   {1, 1, 0},
                                   {2, 5, -1},
                                   {250.0 / 3.0, 12, -3}}) {
        app_config config = drive_config();
        config.loop.rate_Hz = one.rate_Hz;
        CHECK(config_validate(&config).key == nullptr);
        CHECK(config_interpolation_period(&config).value == one.value);
        CHECK(config_interpolation_period(&config).index == one.index);
    }
    app_config config = drive_config();
    config.loop.rate_Hz = 512; /* 1.953125 ms */
    CHECK(std::string(config_validate(&config).key) == "loop.rate_Hz");
    config.robot_channel.profile = ROBOT_PROFILE_BERTH;
    CHECK(config_validate(&config).key == nullptr);
}

TEST_CASE("cia402: a period that is refused as it is written is told in the drive's own unit")
{
    struct period_case {
        double rate_Hz;
        std::set<std::int8_t> indices; /* that the drive takes */
        std::int8_t index;             /* that it has at first */
        int fixed_period;              /* that it keeps; 0: takes any */
        int error;                     /* -1: it gets ready; else what the record has */
    };
    const period_case cases[] = {
        {100, {-3}, -3, 0, -1},     {50, {-3}, -3, 0, -1},     {500, {-3}, -3, 0, -1},
        {400, {-4}, -4, 0, -1},     {100, {-4}, -4, 0, -1},                           /* 100 * 10^-4 s */
        {400, {-5}, -5, 0, -1},     {100, {-2}, -2, 0, -1},    {250, {7}, -3, 4, -1}, /* it has it already */
        {400, {-3}, -3, 0, 0x00fd}, {400, {7}, -3, 4, 0x00fd}, {500, {7}, -3, 4, 0x04fd},
        {10, {-4}, -4, 0, 0x00fc}, /* 1000 * 10^-4 s */
    };
    for (const period_case &one : cases) {
        CAPTURE(one.rate_Hz);
        CAPTURE(one.index);
        app_config config = drive_config();
        config.loop.rate_Hz = one.rate_Hz;
        config.cia402.heartbeat_ms = 100.0;
        REQUIRE(config_validate(&config).key == nullptr);
        drive_bench bench(config);
        bench.indices = one.indices;
        bench.period_index = one.index;
        bench.fixed_period = one.fixed_period;
        if (one.error < 0) {
            REQUIRE(bench.run_until(SUPERVISOR_READY));
            const int value = one.fixed_period != 0 ? one.fixed_period : bench.period_value;
            CHECK(value * std::pow(10.0, bench.period_index) == doctest::Approx(1.0 / one.rate_Hz));
        } else {
            REQUIRE(bench.run_until(SUPERVISOR_FAULT));
            CHECK(bench.trouble() == DRIVE_TROUBLE_NO_PERIOD);
            CHECK(bench.app().recorder.tick.drive_error == static_cast<std::uint32_t>(one.error));
        }
    }
}

TEST_CASE("cia402: an answer to a read may say any size, or none, or come in a segment")
{
    for (const int command : {0x43, 0x42, 0x4e, 0x4f, 0x41, 0x40}) {
        CAPTURE(command);
        drive_bench bench;
        bench.read_command = static_cast<std::uint8_t>(command);
        if (command == 0x4f) { /* one byte of what has more: no CiA 402 device by its type, 0x..0192 */
            REQUIRE(bench.run_until(SUPERVISOR_FAULT));
            CHECK(bench.trouble() == DRIVE_TROUBLE_WRONG_VALUE);
            continue;
        }
        REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
    }
}

TEST_CASE("cia402: a drive without an object to watch the loop is let be where the rig file says so")
{
    app_config config = drive_config();
    config.cia402.must_watch_loop = 0;
    drive_bench bench(config);
    bench.answer_instead[0x101601] = sdo(0x80, 0x1016, 1, 0x06020000);
    CHECK(bench.run_until(SUPERVISOR_RUNNING));
    drive_bench other(config); /* which has it, and does not take it */
    other.answer_instead[0x101601] = sdo(0x80, 0x1016, 1, 0x06090030);
    REQUIRE(other.run_until(SUPERVISOR_FAULT));
    CHECK(other.trouble() == DRIVE_TROUBLE_SDO_ABORT);
}

TEST_CASE("cia402: a drive that does not tell its modes shows by what it takes")
{
    drive_bench bench;
    bench.answer_instead[0x650200] = sdo(0x80, 0x6502, 0, 0x06020000);
    CHECK(bench.run_until(SUPERVISOR_RUNNING));
    drive_bench other;
    other.answer_instead[0x650200] = sdo(0x43, 0x6502, 0, 0x00000001); /* profile position alone */
    REQUIRE(other.run_until(SUPERVISOR_FAULT, 4000));
    CHECK(other.trouble() == DRIVE_TROUBLE_WRONG_VALUE);
}

TEST_CASE("cia402: trouble in words")
{
    const auto said = [](cia402_trouble trouble, int object, std::uint8_t subindex, std::uint32_t error) {
        std::uint32_t step = 0;
        while (step < cia402_setup_steps &&
               cia402_setup_object(step) != static_cast<std::uint32_t>(object << 8 | subindex)) {
            step++;
        }
        char text[CIA402_TEXT_BYTES_MAX];
        cia402_trouble_text(trouble, step, error, text);
        return std::string(text);
    };
    CHECK(said(DRIVE_TROUBLE_NONE, 0x6060, 0, 0).empty());
    CHECK(
        said(DRIVE_TROUBLE_SDO_ABORT, 0x6060, 0, 0x06090030) ==
        "the drive refuses an object, object 0x6060:00, SDO abort code 0x06090030 (the value is invalid); it has no "
        "cyclic synchronous position");
    CHECK(said(DRIVE_TROUBLE_SDO_ABORT, 0x1a00, 1, 0x06040041).find("cannot be mapped into a PDO") !=
          std::string::npos);
    CHECK(said(DRIVE_TROUBLE_SDO_ABORT, 0x6060, 0, 0x12345678).find("maker's own") != std::string::npos);
    CHECK(said(DRIVE_TROUBLE_NO_PERIOD, 0x60c2, 2, 0x00fd) ==
          "the drive cannot take the loop's period, object 0x60C2:02; its unit is 10^-3 s, of which it takes 1 to "
          "255: "
          "set loop.rate_Hz to 1000 divided by such a whole number");
    CHECK(said(DRIVE_TROUBLE_NO_PERIOD, 0x60c2, 1, 0x04fd) ==
          "the drive cannot take the loop's period, object 0x60C2:01; it keeps 4 * 10^-3 s: set loop.rate_Hz = 250");
    CHECK(said(DRIVE_TROUBLE_NO_PERIOD, 0x60c2, 2, 0x0003).find("makes no period of a loop") != std::string::npos);
    CHECK(said(DRIVE_TROUBLE_UNWATCHED, 0x1016, 1, 0).find("object 0x1016:01; cia402.must_watch_loop = false") !=
          std::string::npos);
    CHECK(said(DRIVE_TROUBLE_EMERGENCY, 0, 0, 0x2310).find("EMCY error code 0x2310") != std::string::npos);
    for (int i = 0; i < DRIVE_TROUBLE_COUNT; i++) {
        CHECK(said(static_cast<cia402_trouble>(i), 0x1016, 1, 0xffffffff).size() < CIA402_TEXT_BYTES_MAX - 1);
    }
}

TEST_CASE("cia402: a configuration that cannot be is refused under its key")
{
    const auto refused = [](void (*spoil)(app_config &)) {
        app_config config = drive_config();
        spoil(config);
        const config_error error = config_validate(&config);
        return std::string(error.key != nullptr ? error.key : "");
    };
    CHECK(refused([](app_config &c) { c.cia402.node_id = 0; }) == "cia402.node_id");
    CHECK(refused([](app_config &c) { c.cia402.node_id = 128; }) == "cia402.node_id");
    CHECK(refused([](app_config &c) { c.cia402.master_node_id = 128; }) == "cia402.master_node_id");
    CHECK(refused([](app_config &c) { c.cia402.master_node_id = node; }) == "cia402.master_node_id");
    CHECK(refused([](app_config &c) { c.cia402.counts_per_m = 0.0; }) == "cia402.counts_per_m");
    CHECK(refused([](app_config &c) { c.cia402.counts_per_m = 3e9; }) == "limits.position_min_m");
    CHECK(refused([](app_config &c) { c.cia402.heartbeat_ms = 0.5; }) == "cia402.heartbeat_ms");
    CHECK(refused([](app_config &c) { c.cia402.heartbeat_ms = 1.5; }) == "cia402.heartbeat_ms");
    CHECK(refused([](app_config &c) { c.cia402.stale_after_ms = 70000; }) == "cia402.stale_after_ms");
    CHECK(refused([](app_config &c) { c.cia402.stale_after_ms = 100; }) == "cia402.stale_after_ms");
    CHECK(refused([](app_config &c) { c.cia402.sdo_timeout_ms = 0; }) == "cia402.sdo_timeout_ms");
    CHECK(refused([](app_config &c) { c.cia402.state_timeout_ms = -1; }) == "cia402.state_timeout_ms");
    CHECK(refused([](app_config &c) { c.robot_channel.profile = 2; }) == "robot_channel.profile");
}
