/* What hal.h promises, asked through hal.h alone: the same cases can run on any implementation of it. What is behind
 * the seam is only assumed to send force and feedback, as every rig does. */
#include <cstring>
#include <doctest/doctest.h>
#include <string>
#include <vector>

#include "../../firmware/can/codec.h"
#include "../../firmware/config.h"
#include "../../hal/hal.h"
#include "../support/far_side.h"
#include "../support/files.h"

namespace
{

/* hal_open() as main.c calls it. */
class opened_hal
{
  public:
    explicit opened_hal(std::string rig, std::string log = "") : far_side(rig)
    {
        std::string program = "contract";
        char *arguments[] = {program.data(), rig.data(), log.data(), nullptr};
        status = hal_open(&hal, log.empty() ? 2 : 3, arguments, &config);
    }
    opened_hal(const opened_hal &) = delete;
    opened_hal &operator=(const opened_hal &) = delete;
    ~opened_hal()
    {
        if (hal != nullptr) {
            hal_close(hal);
        }
    }

    hal_status close()
    {
        const hal_status result = hal_close(hal);
        hal = nullptr;
        return result;
    }

    berth::far_side far_side;
    struct hal *hal = nullptr;
    app_config config{};
    hal_status status = HAL_OK;
};

hal_frame setpoint_frame(double position_m, std::uint8_t counter, std::int64_t now_ns)
{
    berth_can_setpoint_t raw{};
    raw.position_m =
        berth_can_setpoint_position_m_encode(codec_round(position_m, berth_can_setpoint_position_m_decode(1)));
    raw.counter = counter;
    hal_frame frame{now_ns, BERTH_CAN_SETPOINT_FRAME_ID, HAL_BUS_ROBOT, BERTH_CAN_SETPOINT_LENGTH, 0, 0, {}};
    berth_can_setpoint_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

/* A log message of its own kind, numbered. */
std::string numbered_record(std::uint32_t number, std::size_t size_bytes)
{
    constexpr std::uint16_t id = 0;
    const auto content = static_cast<std::uint16_t>(size_bytes - 3);
    std::string record(size_bytes, 'x');
    std::memcpy(&record[0], &content, 2);
    record[2] = 'D';
    std::memcpy(&record[3], &id, 2);
    std::memcpy(&record[5], "numbered", 8);
    std::memcpy(&record[13], &number, 4);
    return record;
}

/* Numbers of the whole numbered records in a ULog file; -1 stands for one that is broken. */
std::vector<std::int64_t> numbers_in(const std::string &file, std::size_t size_bytes)
{
    std::vector<std::int64_t> numbers;
    std::size_t place = 16;
    while (place + 3 <= file.size()) {
        std::uint16_t content = 0;
        std::memcpy(&content, &file[place], 2);
        const std::string message = file.substr(place, 3u + content);
        if (message.size() > 17 && message[2] == 'D' && message.compare(5, 8, "numbered") == 0) {
            std::uint32_t number = 0;
            std::memcpy(&number, &message[13], 4);
            numbers.push_back(message == numbered_record(number, size_bytes) ? number : -1);
        }
        place += 3u + content;
    }
    CHECK(place == file.size()); /* ends with a whole message */
    return numbers;
}

} // namespace

TEST_CASE("contract: hal_open fills the configuration, or says what is wrong and leaves no hal")
{
    {
        opened_hal good("ess");
        CHECK(good.status == HAL_OK);
        CHECK(good.hal != nullptr);
        CHECK(config_validate(&good.config).key == nullptr);
        CHECK(good.config.loop.rate_Hz == 400);
    } /* closed: real lines have one owner */

    opened_hal bad("there-is-no-such-rig");
    CHECK(bad.status == HAL_INVALID);
    CHECK(bad.hal == nullptr);

    opened_hal unwritable("ess", "/proc/no-folder-here/log.ulg");
    CHECK(unwritable.status == HAL_INVALID);
    CHECK(unwritable.hal == nullptr);
}

TEST_CASE("contract: ticks are one period apart, keep their phase, and count what was missed")
{
    for (const char *rig : {"ess", "ess-50hz"}) {
        CAPTURE(rig);
        opened_hal open(rig);
        REQUIRE(open.status == HAL_OK);
        const std::int64_t period_ns = config_period_ns(&open.config);
        std::int64_t next_index = 0;
        for (int i = 0; i < 1000; i++) {
            hal_tick tick;
            REQUIRE(hal_wait_tick(open.hal, &tick) == HAL_OK);
            CHECK(tick.index == next_index + tick.missed);
            CHECK(tick.scheduled_ns == tick.index * period_ns);
            CHECK(tick.woke_ns >= tick.scheduled_ns);
            CHECK(tick.stop == 0);
            next_index = tick.index + 1;
        }
    }
}

TEST_CASE("contract: the run ends with HAL_END, and stays ended; before that a stop may be asked for")
{
    opened_hal open("concept-foam");
    REQUIRE(open.status == HAL_OK);
    hal_tick tick;
    std::int64_t ticks = 0; /* in which nobody asks for a stop, missed ones included */
    while (hal_wait_tick(open.hal, &tick) == HAL_OK) {
        ticks = tick.stop == 0 ? tick.index + 1 : ticks;
    }
    CHECK(ticks == 20 * open.config.loop.rate_Hz);
    CHECK(hal_wait_tick(open.hal, &tick) == HAL_END);
    CHECK(hal_wait_tick(open.hal, &tick) == HAL_END);
}

TEST_CASE("contract: a frame is there at the first tick after its arrival, oldest first, then HAL_EMPTY")
{
    opened_hal open("ess");
    REQUIRE(open.status == HAL_OK);
    std::int64_t before_ns = -1; /* the tick before */
    std::int64_t frames = 0;
    for (int i = 0; i < 1000; i++) {
        hal_tick tick;
        REQUIRE(hal_wait_tick(open.hal, &tick) == HAL_OK);
        for (const hal_bus bus : {HAL_BUS_ROBOT, HAL_BUS_SENSOR}) {
            hal_frame frame;
            std::int64_t oldest_ns = before_ns;
            hal_status status = HAL_OK;
            while ((status = hal_can_receive(open.hal, bus, &frame)) == HAL_OK) {
                CHECK(frame.bus == bus);
                CHECK(frame.length <= 8);
                CHECK(frame.id < 0x800);
                CHECK(frame.time_ns <= tick.woke_ns);
                CHECK(frame.time_ns > before_ns); /* else it would have been there a tick ago */
                CHECK(frame.time_ns >= oldest_ns);
                oldest_ns = frame.time_ns;
                frames++;
            }
            CHECK(status == HAL_EMPTY);
            CHECK(hal_can_receive(open.hal, bus, &frame) == HAL_EMPTY);
        }
        before_ns = tick.woke_ns;
    }
    CHECK(frames > 2000);
}

TEST_CASE("contract: frames wait for a loop that does not take them")
{
    opened_hal open("ess");
    REQUIRE(open.status == HAL_OK);
    hal_tick tick;
    for (int i = 0; i < 50; i++) {
        REQUIRE(hal_wait_tick(open.hal, &tick) == HAL_OK);
    }
    hal_frame frame;
    std::int64_t last_ns = -1;
    int frames = 0;
    while (hal_can_receive(open.hal, HAL_BUS_SENSOR, &frame) == HAL_OK) {
        CHECK(frame.time_ns > last_ns);
        last_ns = frame.time_ns;
        frames++;
    }
    CHECK(frames >= 48);
}

TEST_CASE("contract: a setpoint that is sent comes back in the robot's feedback")
{
    opened_hal open("ess");
    REQUIRE(open.status == HAL_OK);
    std::uint8_t newest = 0;
    double position_m = 0.0;
    for (std::uint8_t i = 0; i < 200; i++) {
        hal_tick tick;
        REQUIRE(hal_wait_tick(open.hal, &tick) == HAL_OK);
        hal_frame frame;
        while (hal_can_receive(open.hal, HAL_BUS_ROBOT, &frame) == HAL_OK) {
            berth_can_robot_feedback_t raw;
            if (frame.id == BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID) {
                REQUIRE(berth_can_robot_feedback_unpack(&raw, frame.data, frame.length) >= 0);
                newest = raw.setpoint_counter;
                position_m = berth_can_robot_feedback_position_m_decode(raw.position_m);
            }
        }
        const hal_frame sent = setpoint_frame(0.011, i, tick.scheduled_ns);
        REQUIRE(hal_can_send(open.hal, &sent) == HAL_OK);
    }
    CHECK(newest >= 190);
    CHECK(position_m == doctest::Approx(0.011).epsilon(1e-4));
}

TEST_CASE("contract: input lines have a level, output lines take one")
{
    opened_hal open("ess");
    REQUIRE(open.status == HAL_OK);
    hal_tick tick;
    for (int i = 0; i < 2; i++) { /* the simulated person gives the enable after the first one */
        REQUIRE(hal_wait_tick(open.hal, &tick) == HAL_OK);
    }
    std::uint8_t level = 0xff;
    CHECK(hal_gpio_get(open.hal, HAL_LINE_ENABLE, &level) == HAL_OK);
    CHECK(level == 1);
    CHECK(hal_gpio_get(open.hal, HAL_LINE_EMERGENCY_STOP, &level) == HAL_OK);
    CHECK(level == 0);
    for (const std::uint8_t out : {1, 0, 1}) {
        CHECK(hal_gpio_set(open.hal, HAL_LINE_HEARTBEAT, out) == HAL_OK);
        CHECK(hal_gpio_set(open.hal, HAL_LINE_FAULT, out) == HAL_OK);
    }
}

TEST_CASE("contract: all that was recorded is in the log after hal_close, in order and whole")
{
    const berth::temporary_folder folder;
    const std::string log = folder / "log.ulg";
    opened_hal open("ess", log);
    REQUIRE(open.status == HAL_OK);
    constexpr std::size_t size_bytes = 701; /* no divisor of any buffer */
    constexpr std::uint32_t ticks = 2000;
    for (std::uint32_t i = 0; i < ticks; i++) {
        hal_tick tick;
        REQUIRE(hal_wait_tick(open.hal, &tick) == HAL_OK);
        const std::string record = numbered_record(i, size_bytes);
        REQUIRE(hal_record(open.hal, record.data(), record.size()) == HAL_OK);
    }
    CHECK(open.close() == HAL_OK);
    const std::vector<std::int64_t> numbers = numbers_in(berth::read_bytes(log), size_bytes);
    REQUIRE(numbers.size() == ticks);
    for (std::uint32_t i = 0; i < ticks; i++) {
        REQUIRE(numbers[i] == i);
    }
}

TEST_CASE("contract: a record that finds the ring full is dropped whole, counted, and said at hal_close")
{
    const berth::temporary_folder folder;
    const std::string log = folder / "log.ulg";
    opened_hal open("ess", log);
    REQUIRE(open.status == HAL_OK);
    hal_tick tick;
    REQUIRE(hal_wait_tick(open.hal, &tick) == HAL_OK);
    constexpr std::size_t size_bytes = 60001;
    std::vector<std::int64_t> taken;
    for (std::uint32_t i = 0; i < 200; i++) { /* 12 MB within one tick */
        const std::string record = numbered_record(i, size_bytes);
        const hal_status status = hal_record(open.hal, record.data(), record.size());
        CHECK((status == HAL_OK || status == HAL_NO_BUFFER));
        if (status == HAL_OK) {
            taken.push_back(i);
        }
    }
    CHECK(taken.size() > 0);
    CHECK(taken.size() < 200);
    CHECK(open.close() == HAL_INVALID);
    CHECK(numbers_in(berth::read_bytes(log), size_bytes) == taken);
}

TEST_CASE("contract: a hal that was opened can be closed at once, with a log that can be read")
{
    const berth::temporary_folder folder;
    opened_hal open("ess", folder / "log.ulg");
    REQUIRE(open.status == HAL_OK);
    CHECK(open.close() == HAL_OK);
    const std::string file = berth::read_bytes(folder / "log.ulg");
    CHECK(file.substr(0, 7) == std::string("ULog\x01\x12\x35", 7));
    CHECK(numbers_in(file, 100).empty());
}
