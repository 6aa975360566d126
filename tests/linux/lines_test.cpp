/* The kernel's simulated lines, set and seen from outside of their chip; each case runs with both interfaces of
 * libgpiod. */
#include <unistd.h>

#include <atomic>
#include <cstring>
#include <doctest/doctest.h>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include "../../firmware/config.h"
#include "../../hal/hal.h"
#include "../../hal/linux/gpio_lines.h"
#include "../../hal/linux/loop_time.h"
#include "../../hal/linux/machine.h"

namespace berth
{

namespace
{

/* What the far end of a line's wire sees and does. */
class line_outside
{
  public:
    explicit line_outside(const std::string &name)
    {
        const std::string chip = "/sys/kernel/config/gpio-sim/rig/";
        int number = 0;
        while (first_line_of(chip + "bank/line" + std::to_string(number) + "/name") != name) {
            number++;
            REQUIRE(number < 100);
        }
        folder_ = "/sys/devices/platform/" + first_line_of(chip + "dev_name") + "/" +
                  first_line_of(chip + "bank/chip_name") + "/sim_gpio" + std::to_string(number);
    }

    std::string level() const { return first_line_of(folder_ + "/value"); }

    void pull(const char *direction) const
    {
        std::ofstream file(folder_ + "/pull");
        file << "pull-" << direction << std::flush;
        REQUIRE(file.good());
    }

  private:
    std::string folder_;
};

struct opened_hal {
    opened_hal()
    {
        std::string program = "contract";
        std::string rig = "ess";
        char *arguments[] = {program.data(), rig.data(), nullptr};
        app_config config{};
        REQUIRE(hal_open(&hal, 2, arguments, &config) == HAL_OK);
    }
    opened_hal(const opened_hal &) = delete;
    opened_hal &operator=(const opened_hal &) = delete;
    ~opened_hal() { hal_close(hal); }

    struct hal *hal = nullptr;
};

struct line_closer {
    void operator()(gpio_line *line) const { gpio_line_close(line); }
};
using open_line = std::unique_ptr<gpio_line, line_closer>;

open_line take(const char *name, gpio_direction direction, bool is_active_low, std::string *says = nullptr)
{
    char error[200] = "";
    open_line line(gpio_line_open("", name, direction, is_active_low, error, sizeof error));
    if (says != nullptr) {
        *says = error;
    }
    return line;
}

} // namespace

TEST_CASE("contract: output lines are seen outside, that of the tick from its wake-up on")
{
    const opened_hal open;
    const line_outside tick_line("TICK");
    CHECK(tick_line.level() == "0");
    for (int i = 0; i < 3; i++) {
        hal_tick tick;
        REQUIRE(hal_wait_tick(open.hal, &tick) == HAL_OK);
        CHECK(tick_line.level() == "1");
        for (const std::uint8_t level : {1, 0, 1, 1, 0}) {
            CAPTURE(int{level});
            CHECK(hal_gpio_set(open.hal, HAL_LINE_HEARTBEAT, level) == HAL_OK);
            CHECK(hal_gpio_set(open.hal, HAL_LINE_FAULT, 1 - level) == HAL_OK);
            CHECK(line_outside("HEARTBEAT").level() == std::to_string(level));
            CHECK(line_outside("FAULT").level() == std::to_string(1 - level));
        }
    }
}

TEST_CASE("contract: the tick's line is low again until the next one")
{
    const line_outside tick_line("TICK");
    std::atomic<bool> is_over{false};
    std::atomic<int> seen_high{0};
    std::atomic<int> seen_low_after_high{0};
    std::thread observer([&] { /* runs while the loop sleeps */
                               for (bool was_high = false; !is_over; usleep(100)) {
                                   const bool is_high = tick_line.level() == "1";
                                   seen_high += is_high;
                                   seen_low_after_high += was_high && !is_high;
                                   was_high |= is_high;
                               }
    });
    {
        const opened_hal open;
        for (int i = 0; i < 100; i++) {
            hal_tick tick;
            CHECK(hal_wait_tick(open.hal, &tick) == HAL_OK);
            usleep(500);
        }
        is_over = true;
        observer.join(); /* while the line is still the loop's */
    }
    CHECK(seen_high > 50);
    CHECK(seen_low_after_high > 100);
}

TEST_CASE("contract: input lines are read anew in each tick; low is pressed, and high is enabled")
{
    const opened_hal open;
    const line_outside emergency_stop("EMERGENCY_STOP");
    const line_outside enable("ENABLE");
    for (const char *direction : {"up", "down", "up"}) {
        CAPTURE(direction);
        emergency_stop.pull(direction);
        enable.pull(direction);
        hal_tick tick;
        for (int i = 0; i < 2; i++) { /* in the first one the edge may count as well */
            REQUIRE(hal_wait_tick(open.hal, &tick) == HAL_OK);
        }
        std::uint8_t level = 0xff;
        CHECK(hal_gpio_get(open.hal, HAL_LINE_EMERGENCY_STOP, &level) == HAL_OK);
        CHECK(level == (std::strcmp(direction, "down") == 0));
        CHECK(hal_gpio_get(open.hal, HAL_LINE_ENABLE, &level) == HAL_OK);
        CHECK(level == (std::strcmp(direction, "up") == 0));
    }
}

TEST_CASE("contract: a press between two ticks is one, however short")
{
    const opened_hal open;
    const line_outside emergency_stop("EMERGENCY_STOP");
    for (int i = 0; i < 10; i++) {
        hal_tick tick;
        std::uint8_t level = 0;
        REQUIRE(hal_wait_tick(open.hal, &tick) == HAL_OK);
        emergency_stop.pull("down");
        emergency_stop.pull("up");
        REQUIRE(hal_wait_tick(open.hal, &tick) == HAL_OK);
        CHECK(hal_gpio_get(open.hal, HAL_LINE_EMERGENCY_STOP, &level) == HAL_OK);
        CHECK(level == 1);
        REQUIRE(hal_wait_tick(open.hal, &tick) == HAL_OK);
        CHECK(hal_gpio_get(open.hal, HAL_LINE_EMERGENCY_STOP, &level) == HAL_OK);
        CHECK(level == 0);
    }
}

TEST_CASE("contract: both edges of a line come with the kernel's stamps, in order, in positive logic")
{
    const line_outside outside("EMERGENCY_STOP");
    const open_line line = take("EMERGENCY_STOP", GPIO_IN_WITH_EDGES, true);
    REQUIRE(line != nullptr);
    gpio_edge edge;
    CHECK(gpio_line_next_edge(line.get(), &edge) == 0);
    std::int64_t changed_ns[3] = {read_clock_ns(CLOCK_MONOTONIC), 0, 0};
    const char *const directions[] = {"down", "up"};
    for (int i = 0; i < 2; i++) {
        outside.pull(directions[i]);
        usleep(10000); /* or the simulated chip makes one interrupt of both */
        changed_ns[i + 1] = read_clock_ns(CLOCK_MONOTONIC);
    }
    usleep(50000); /* the stamp is of the edge, not of its reading */
    for (int i = 0; i < 2; i++) {
        REQUIRE(gpio_line_next_edge(line.get(), &edge) == 1);
        CHECK(edge.level == 1 - i);
        CHECK(edge.time_ns >= changed_ns[i]);
        CHECK(edge.time_ns <= changed_ns[i + 1]);
    }
    CHECK(gpio_line_next_edge(line.get(), &edge) == 0);
}

TEST_CASE("contract: a line has one owner, and one that is not there is named")
{
    std::string says;
    const open_line first = take("FAULT", GPIO_OUT, false);
    REQUIRE(first != nullptr);
    CHECK(take("FAULT", GPIO_OUT, false, &says) == nullptr);
    CHECK(says.find("does another program hold it?") != std::string::npos);
    CHECK(take("NOWHERE", GPIO_IN, false, &says) == nullptr);
    CHECK(says.find("no GPIO line is called \"NOWHERE\"") != std::string::npos);
}

TEST_CASE("contract: a chip goes by its name and by its label")
{
    const std::string name = first_line_of("/sys/kernel/config/gpio-sim/rig/bank/chip_name");
    for (const std::string &chip : {name, std::string("rig"), std::string("no-such-chip")}) {
        CAPTURE(chip);
        char error[200] = "";
        const open_line line(gpio_line_open(chip.c_str(), "FAULT", GPIO_OUT, 0, error, sizeof error));
        CHECK((line != nullptr) == (chip != "no-such-chip"));
    }
}

} // namespace berth
