#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <string>

#include "firmware/robot_channel.h"
#include "not_finite.h"
#include "seeded.h"
#include "tick_builder.h"

namespace
{

constexpr double step_m = 1e-11;
constexpr double range_m = 5.4;

struct sender {
    app_config config = config_default();
    robot_channel channel{};
    supervisor supervisor_{};
    hal_tick tick{1, 2500000, 2500000, 0, 0}; /* index 1: no status frame */
    tick_output out{};

    explicit sender(supervisor_state state = SUPERVISOR_RUNNING, std::int64_t rate_Hz = 400)
    {
        config.loop.rate_Hz = rate_Hz;
        robot_channel_start(&channel, &config);
        supervisor_start(&supervisor_);
        supervisor_.state = state;
    }

    double send(double position_m, std::uint32_t limits = 0, std::uint32_t missed_ticks = 0,
                std::uint32_t torn_samples = 0)
    {
        out.frame_count = 0;
        const robot_command command{position_m, limits, missed_ticks, torn_samples, 0, 1, {}};
        return robot_channel_send(&channel, &supervisor_, &tick, &command, &out);
    }

    const hal_frame *sent(std::uint32_t id) const
    {
        for (std::uint32_t i = 0; i < out.frame_count; i++) {
            if (out.frames[i].id == id) {
                return &out.frames[i];
            }
        }
        return nullptr;
    }

    berth_can_setpoint_t setpoint() const
    {
        berth_can_setpoint_t raw{};
        const hal_frame *frame = sent(BERTH_CAN_SETPOINT_FRAME_ID);
        REQUIRE(frame != nullptr);
        REQUIRE(berth_can_setpoint_unpack(&raw, frame->data, frame->length) == 0);
        return raw;
    }
};

} // namespace

TEST_CASE("robot_channel: a setpoint survives the wire within half a step")
{
    SEEDED(random, "robot_channel:*");
    sender sender;
    double worst_steps = 0.0;
    int differs_from_record = 0;
    for (int i = 0; i < 100000; i++) {
        const double wanted_m = seeded::uniform(random, -range_m, range_m) * (i % 2 ? 1.0 : 1e-6);
        const double recorded_m = sender.send(wanted_m);
        const double on_wire_m = static_cast<double>(sender.setpoint().position_m) * step_m;
        worst_steps = std::fmax(worst_steps, std::fabs(on_wire_m - wanted_m) / step_m);
        differs_from_record += on_wire_m != recorded_m;
    }
    CHECK(worst_steps <= 0.5 + 2e-4); /* an ulp at 5.4 m is 9e-5 steps */
    CHECK(worst_steps > 0.49);
    CHECK(differs_from_record == 0);
    CHECK(sender.channel.saturated_setpoints == 0);
}

TEST_CASE("robot_channel: beyond +-5.4 m a setpoint is sent at the end of the range and counted, it never wraps")
{
    sender sender;
    std::uint32_t count = 0;
    for (const double beyond_m : {5.4 + 1e-9, 5.5, 5.4975581388, 8.0, 10.995, 11.0, 2000.0, 1e9, 1e300, infinity}) {
        for (const double sign : {1.0, -1.0}) {
            CAPTURE(sign * beyond_m);
            CHECK(sender.send(sign * beyond_m) == doctest::Approx(sign * range_m).epsilon(1e-12));
            CHECK(sender.setpoint().position_m == static_cast<std::int64_t>(sign) * 540000000000);
            CHECK(sender.channel.saturated_setpoints == ++count);
        }
    }
    sender.send(std::nan(""));
    CHECK(sender.setpoint().position_m == 0);
    CHECK(sender.channel.saturated_setpoints == ++count);
    for (const double end_m : {range_m, -range_m}) {
        sender.send(end_m);
        CHECK(std::llabs(sender.setpoint().position_m) == 540000000000);
        CHECK(sender.channel.saturated_setpoints == count);
    }
}

TEST_CASE("robot_channel: each state sends what its rows allow and nothing else")
{
    const struct {
        supervisor_state state;
        bool setpoint, motion_allowed;
    } rows[] = {
        {SUPERVISOR_START, false, false},  {SUPERVISOR_READY, true, false}, {SUPERVISOR_RUNNING, true, true},
        {SUPERVISOR_HOLDING, true, false}, {SUPERVISOR_FAULT, true, false}, {SUPERVISOR_STOPPED, false, false},
    };
    CHECK(sizeof rows / sizeof rows[0] == SUPERVISOR_STATE_COUNT);
    for (const auto &row : rows) {
        CAPTURE(std::string(supervisor_state_name(row.state)));
        sender sender(row.state);
        sender.tick = {0, 0, 0, 0, 0};
        sender.send(0.5);
        CHECK((sender.sent(BERTH_CAN_SETPOINT_FRAME_ID) != nullptr) == row.setpoint);
        CHECK(sender.sent(BERTH_CAN_LOOP_STATUS_FRAME_ID) != nullptr);
        CHECK(sender.out.frame_count == (row.setpoint ? 2 : 1));
        CHECK(sender.channel.setpoint_counter == (row.setpoint ? 1 : 0));
        if (row.setpoint) {
            CHECK(sender.setpoint().motion_allowed == row.motion_allowed);
        }
    }
}

TEST_CASE("robot_channel: a saturated setpoint that may not be sent is not counted")
{
    sender sender(SUPERVISOR_START);
    sender.send(6.0);
    CHECK(sender.channel.saturated_setpoints == 0);
}

TEST_CASE("robot_channel: frames carry the tick's time, the robot's bus and a counter that wraps")
{
    sender sender;
    for (int i = 0; i < 600; i++) {
        sender.send(0.0);
        REQUIRE(sender.setpoint().counter == i % 256);
    }
    const hal_frame &frame = *sender.sent(BERTH_CAN_SETPOINT_FRAME_ID);
    CHECK(frame.time_ns == 2500000);
    CHECK(frame.bus == HAL_BUS_ROBOT);
    CHECK(frame.length == 8);
    CHECK(frame.flags == 0);
}

TEST_CASE("robot_channel: the status goes out ten times a second, or every tick of a slower loop")
{
    const struct {
        std::int64_t rate_Hz;
        int in_ten_seconds;
    } rows[] = {{400, 100}, {50, 100}, {1000, 100}, {10, 100}, {5, 50}};
    for (const auto &row : rows) {
        CAPTURE(row.rate_Hz);
        sender sender(SUPERVISOR_READY, row.rate_Hz);
        int count = 0;
        for (std::int64_t i = 0; i < 10 * row.rate_Hz; i++) {
            sender.tick.index = i;
            sender.send(0.0);
            const hal_frame *frame = sender.sent(BERTH_CAN_LOOP_STATUS_FRAME_ID);
            if (frame != nullptr) {
                berth_can_loop_status_t raw{};
                REQUIRE(berth_can_loop_status_unpack(&raw, frame->data, frame->length) == 0);
                CHECK(raw.counter == count++ % 256);
            }
        }
        CHECK(count == row.in_ten_seconds);
    }
}

TEST_CASE("robot_channel: the status says state, cause, limits, missed ticks and torn samples")
{
    sender sender(SUPERVISOR_FAULT);
    sender.supervisor_.stop_cause = STOP_FORCE_LIMIT;
    sender.tick.index = 0;
    berth_can_loop_status_t raw{};
    const auto status = [&] {
        const hal_frame *frame = sender.sent(BERTH_CAN_LOOP_STATUS_FRAME_ID);
        REQUIRE(frame != nullptr);
        REQUIRE(berth_can_loop_status_unpack(&raw, frame->data, frame->length) == 0);
    };
    sender.send(0.0, LIMIT_VELOCITY | LIMIT_ACCELERATION, 17, 300);
    status();
    CHECK(raw.state == SUPERVISOR_FAULT);
    CHECK(raw.stop_cause == STOP_FORCE_LIMIT);
    CHECK(raw.limits == (LIMIT_VELOCITY | LIMIT_ACCELERATION));
    CHECK(raw.missed_ticks == 17);
    CHECK(raw.torn_samples == 300);
    sender.send(0.0, 0, 70000, 65536);
    status();
    CHECK(raw.missed_ticks == 65535); /* saturates, does not wrap */
    CHECK(raw.torn_samples == 65535);
}
