/* What the set-up of a CiA 402 drive does where a drive lacks something, and when it moves by itself. Whole drives
 * are in tests/python/test_drive_zoo.py. */
#include <algorithm>
#include <string>

#include "drive_bench.h"
#include "hal/linux/raw_frame.h"

using bench::bytes;
using bench::drive_bench;
using bench::drive_config;
using bench::node;
using bench::sdo;

namespace
{

constexpr std::uint32_t no_object = 0x06020000;

void lacks(drive_bench &bench, int object, std::uint8_t subindex = 0)
{
    bench.answer_instead[object << 8 | subindex] = sdo(0x80, object, subindex, no_object);
}

/* A drive without heartbeat, in motion. */
void run_guarded(drive_bench &bench)
{
    bench.heartbeats = false;
    lacks(bench, 0x1017);
    REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
}

long writes_of(const drive_bench &bench, int object)
{
    return std::count_if(bench.requests.begin(), bench.requests.end(), [&](const bytes &request) {
        return (request[0] & 0xe0) == 0x20 && (request[1] | request[2] << 8) == object;
    });
}

app_config homing_config()
{
    app_config config = drive_config();
    config.cia402.homing_method = -3;
    config.cia402.homing_timeout_ms = 3000.0;
    REQUIRE(config_validate(&config).key == nullptr);
    return config;
}

} // namespace

TEST_CASE("cia402 ways: a drive without heartbeat is polled, by remote frames without data")
{
    drive_bench bench;
    run_guarded(bench);
    CHECK(std::count(bench.requests.begin(), bench.requests.end(), sdo(0x2b, 0x100c, 0, 100)) == 1);
    CHECK(std::count(bench.requests.begin(), bench.requests.end(), sdo(0x2f, 0x100d, 0, 3)) == 1);
    CHECK(writes_of(bench, 0x1016) == 0);
    bench.run(1000);
    CHECK(bench.state() == SUPERVISOR_RUNNING);
    for (std::size_t i = 1; i < bench.polls.size(); i++) {
        CHECK(bench.polls[i] - bench.polls[i - 1] == 40); /* 100 ms */
    }
    while (bench.polls.back() != bench.app().recorder.tick.index) {
        bench.tick();
    }
    const hal_frame *poll = bench.sent(0x700 + node);
    REQUIRE(poll != nullptr);
    CHECK(poll->length == 0);
    CHECK(poll->flags == HAL_FRAME_REMOTE);
    CHECK(berth::raw_frame(*poll).can_id == (0x705u | CAN_RTR_FLAG)); /* as the kernel takes it */
    CHECK(berth::raw_frame(*poll).can_dlc == 0);
    REQUIRE(bench.sent(0x200 + node) != nullptr);
    CHECK(berth::raw_frame(*bench.sent(0x200 + node)).can_id == 0x205);
}

TEST_CASE("cia402 ways: a guarded drive that is silent, or repeats its toggle bit, is missing")
{
    for (const bool repeats : {false, true}) {
        CAPTURE(repeats);
        drive_bench bench;
        run_guarded(bench);
        bench.run(300);
        (repeats ? bench.toggles : bench.answers_polls) = false;
        REQUIRE(bench.run_until(SUPERVISOR_FAULT, 162));
        CHECK(bench.trouble() == DRIVE_TROUBLE_HEARTBEAT);
        bench.toggles = bench.answers_polls = true;
        bench.check_reset_brings_back();
    }
}

TEST_CASE("cia402 ways: one lost answer to a poll is no reason to stop")
{
    drive_bench bench;
    run_guarded(bench);
    for (int i = 0; i < 5; i++) {
        bench.answers_polls = false;
        bench.run(40);
        bench.answers_polls = true;
        bench.run(160);
        CHECK(bench.state() == SUPERVISOR_RUNNING);
    }
}

TEST_CASE("cia402 ways: a guarded drive that cannot watch the loop is refused, unless the rig file lets it be")
{
    app_config config = drive_config();
    for (const bool is_demanded : {true, false}) {
        config.cia402.must_watch_loop = is_demanded;
        drive_bench bench(config);
        bench.heartbeats = false;
        lacks(bench, 0x1017);
        lacks(bench, 0x100d);
        if (is_demanded) {
            REQUIRE(bench.run_until(SUPERVISOR_FAULT));
            CHECK(bench.trouble() == DRIVE_TROUBLE_UNWATCHED);
        } else {
            REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
            bench.run(80);
            CHECK(bench.polls.size() > 1);
            CHECK(bench.state() == SUPERVISOR_RUNNING);
        }
    }
}

TEST_CASE("cia402 ways: a drive that never shows the mode is enabled, and then refused before it runs")
{
    drive_bench bench;
    bench.answer_instead[0x606100] = sdo(0x4f, 0x6061, 0, 1);
    int running = 0;
    for (int i = 0; i < 4000 && bench.state() != SUPERVISOR_FAULT; i++) {
        bench.tick();
        running += bench.state() == SUPERVISOR_RUNNING;
    }
    CHECK(bench.trouble() == DRIVE_TROUBLE_WRONG_VALUE);
    CHECK(bench.app().recorder.tick.drive_error == 1);
    CHECK(cia402_setup_object(bench.app().recorder.tick.drive_setup_step) == 0x606100);
    CHECK(running == 0);
    bench.answer_instead.clear();
    bench.check_reset_brings_back();
}

TEST_CASE("cia402 ways: an enabled drive is led to the first setpoint, and stays where it is after a fault")
{
    constexpr std::int32_t wanted = 100000;
    constexpr std::int32_t start = wanted + 15000; /* 1.5 mm; 2 mm a second are 50 counts a tick */
    drive_bench bench;
    bench.position = start;
    bench.request = OPERATOR_NONE;
    for (int i = 0; i < 2000 && bench.statusword != 0x1237; i++) {
        bench.tick();
        CHECK(bench.position == start);
    }
    bench.run(100);
    CHECK(bench.state() == SUPERVISOR_READY);
    CHECK(bench.position <= start - 98 * 50);
    CHECK(bench.position >= start - 102 * 50);
    bench.emergency_stop = 1;
    bench.run(3);
    const std::int32_t stopped_at = bench.position;
    bench.run(400);
    CHECK(bench.state() == SUPERVISOR_FAULT);
    CHECK(bench.sent_controlword() == 0x0f);
    CHECK(bench.position == stopped_at);
    bench.emergency_stop = 0;
    bench.request = OPERATOR_RESET;
    REQUIRE(bench.run_until(SUPERVISOR_READY));
    CHECK(bench.position == stopped_at);
    bench.run(400);
    CHECK(bench.position == wanted);
}

TEST_CASE("cia402 ways: a homing waits for the enable line, and ends without it")
{
    struct stop_case {
        const char *what;
        void (*stop)(drive_bench &);
        void (*release)(drive_bench &);
    };
    const stop_case cases[] = {
        {"enable", [](drive_bench &b) { b.enable = 0; }, [](drive_bench &b) { b.enable = 1; }},
        {"emergency stop", [](drive_bench &b) { b.emergency_stop = 1; },
         [](drive_bench &b) { b.emergency_stop = 0; }},
        {"homing error", [](drive_bench &b) { b.homing_bits = 0x2000; }, [](drive_bench &b) { b.homing_bits = 0; }},
        {"time", [](drive_bench &b) { b.run(1300); }, [](drive_bench &) {}},
    };
    for (const stop_case &one : cases) {
        CAPTURE(std::string(one.what));
        drive_bench bench(homing_config());
        bench.enable = 0;
        bench.run(500);
        CHECK(bench.state() == SUPERVISOR_START);
        CHECK(writes_of(bench, 0x6098) == 1);
        CHECK(writes_of(bench, 0x6040) == 0);
        bench.enable = 1;
        bench.run(200);
        CHECK(bench.state() == SUPERVISOR_START);
        CHECK(bench.statusword == 0x1237); /* it moves */
        one.stop(bench);
        bench.run(5);
        CHECK(bench.state() == SUPERVISOR_FAULT);
        CHECK(bench.statusword == 0x0250);
        CHECK(bench.requests.back() == sdo(0x2b, 0x6040, 0, 0));
        one.release(bench);
        bench.run(10);
        const std::size_t before = bench.requests.size();
        bench.run(100);
        CHECK(bench.requests.size() == before); /* told once it has answered */
        bench.homing_bits = 0x0400;
        bench.enable = HAL_LEVEL_NOT_WIRED; /* wired, it would have to be given again in ready */
        bench.check_reset_brings_back();
        CHECK(writes_of(bench, 0x6098) == 2);
    }
}

TEST_CASE("cia402 ways: a drive is homed once, and again after it may have been without power")
{
    drive_bench bench(homing_config());
    bench.homing_bits = 0x0400;
    REQUIRE(bench.run_until(SUPERVISOR_RUNNING));
    CHECK(std::count(bench.requests.begin(), bench.requests.end(), sdo(0x2f, 0x6098, 0, 0xfd)) == 1);
    CHECK(std::count(bench.requests.begin(), bench.requests.end(), sdo(0x2f, 0x6060, 0, 6)) == 1);
    bench.emergency_stop = 1;
    bench.run(400);
    bench.emergency_stop = 0;
    bench.check_reset_brings_back();
    CHECK(writes_of(bench, 0x6098) == 1);
    bench.heartbeats = false;
    REQUIRE(bench.run_until(SUPERVISOR_FAULT, 200));
    bench.heartbeats = true;
    bench.check_reset_brings_back();
    CHECK(writes_of(bench, 0x6098) == 2);
}

TEST_CASE("cia402 ways: factors that cannot be are refused under their key")
{
    const auto refused = [](void (*spoil)(app_config &)) {
        app_config config = drive_config();
        spoil(config);
        const config_error error = config_validate(&config);
        return std::string(error.key != nullptr ? error.key : "");
    };
    CHECK(refused([](app_config &c) { c.cia402.homing_method = 128; }) == "cia402.homing_method");
    CHECK(refused([](app_config &c) { c.cia402.homing_method = -129; }) == "cia402.homing_method");
    CHECK(refused([](app_config &c) { c.cia402.homing_timeout_ms = 0; }) == "cia402.homing_timeout_ms");
    CHECK(refused([](app_config &c) { c.cia402.encoder_counts = 4096; }) == "cia402.encoder_counts");
    CHECK(refused([](app_config &c) { c.cia402.gear_shaft_revolutions = 1; }) == "cia402.gear_motor_revolutions");
    CHECK(refused([](app_config &c) {
              c.cia402.feed_counts = INT64_C(1) << 32;
              c.cia402.feed_shaft_revolutions = 1;
          }) == "cia402.feed_counts");
    CHECK(refused([](app_config &c) { c.cia402.polarity = 3; }) == "cia402.polarity");
    CHECK(refused([](app_config &c) {
              c.cia402.homing_method = -128;
              c.cia402.encoder_counts = 0xffffffff;
              c.cia402.encoder_revolutions = 1;
              c.cia402.polarity = 2;
          }).empty());
}
