/* The simulated robot's command side: order, loss, its own clock, jitter, limits. Frames are handed over directly;
 * the robot's course is read between its events. */
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>
#include <functional>
#include <memory>

#include "../../firmware/can/codec.h"
#include "../../hal/rig/rig_file.h"
#include "../../sim_hal/hil/robot.h"
#include "../support/seed.h"

namespace berth
{

namespace
{

constexpr std::int64_t period_ns = 2500000;
constexpr double setpoint_period_s = 1e-9 * period_ns;

hal_frame setpoint_frame(std::int64_t tick, double position_m)
{
    berth_can_setpoint_t raw{};
    raw.position_m =
        berth_can_setpoint_position_m_encode(codec_round(position_m, berth_can_setpoint_position_m_decode(1)));
    raw.counter = static_cast<std::uint8_t>(tick);
    hal_frame frame{tick * period_ns, BERTH_CAN_SETPOINT_FRAME_ID, HAL_BUS_ROBOT, 8, 0, 0, {}};
    berth_can_setpoint_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

/* A robot that gets one setpoint a tick; what it does between the ticks is told to whoever wants to know. */
class driven_robot
{
  public:
    explicit driven_robot(std::vector<std::string> overrides)
    {
        overrides.push_back("manipulator.initial_position_m=0");
        rig_ = load_rig("ess", overrides);
        robot_ = std::make_unique<robot>(rig_);
    }

    /* Called after each event with its instant and the jump of the reference. */
    std::function<void(std::int64_t now_ns, double jump_m)> on_event = [](std::int64_t, double) {};

    void run_until(std::int64_t end_ns)
    {
        while (robot_->next_event_ns() <= end_ns) {
            const std::int64_t now_ns = robot_->next_event_ns();
            REQUIRE(now_ns >= now_ns_); /* time never runs backwards */
            now_ns_ = now_ns;
            const double jump_m = robot_->handle_event();
            on_event(now_ns, jump_m);
        }
    }

    void send(std::int64_t tick, double position_m)
    {
        run_until(tick * period_ns);
        const hal_frame frame = setpoint_frame(tick, position_m);
        robot_->receive(frame, frame.time_ns + 135000);
    }

    double position_m(std::int64_t now_ns)
    {
        run_until(now_ns);
        return robot_->line(now_ns).position_m;
    }

    robot &get() { return *robot_; }

  private:
    rig rig_;
    std::unique_ptr<robot> robot_;
    std::int64_t now_ns_ = 0;
};

/* Setpoints that all differ. */
double walk_m(std::int64_t tick)
{
    return 1e-3 * std::sin(0.37 * static_cast<double>(tick)) + 1e-6 * static_cast<double>(tick);
}

} // namespace

TEST_CASE("robot: straight lines pass through every setpoint one dead time after it was sent")
{
    constexpr std::int64_t dead_time_ns = 16123457;
    driven_robot driven({"robot.dead_time_ms=16.123457"});
    for (std::int64_t tick = 0; tick < 500; tick++) {
        driven.send(tick, walk_m(tick));
        /* Two instants between this tick and the next, both on lines between setpoints sent before. */
        for (const std::int64_t later_ns : {dead_time_ns % period_ns, dead_time_ns % period_ns + 300000}) {
            const std::int64_t now_ns = tick * period_ns + later_ns;
            const double sent = static_cast<double>(now_ns - dead_time_ns) / static_cast<double>(period_ns);
            if (sent < 0.0) {
                continue;
            }
            const auto passed = static_cast<std::int64_t>(std::floor(sent + 1e-9));
            const double share = sent - static_cast<double>(passed);
            const double expected_m = (1.0 - share) * walk_m(passed) + share * walk_m(passed + 1);
            CHECK(std::abs(driven.position_m(now_ns) - expected_m) < 2e-11);
        }
    }
}

TEST_CASE("robot: hold jumps to each setpoint in the order in which they were sent, jitter or not")
{
    REPRODUCIBLE();
    for (const char *jitter : {"robot.jitter_ms=0", "robot.jitter_ms=1.2"}) {
        CAPTURE(jitter);
        driven_robot driven({"robot.interpolation=hold", "robot.dead_time_ms=17.5", jitter,
                             "run.seed=" + std::to_string(test_seed())});
        std::vector<double> sizes_m;
        driven.on_event = [&](std::int64_t, double jump_m) { sizes_m.push_back(jump_m); };
        constexpr std::int64_t ticks = 2000;
        for (std::int64_t tick = 0; tick < ticks; tick++) {
            driven.send(tick, walk_m(tick + 1));
        }
        driven.run_until((ticks + 10) * period_ns);
        REQUIRE(sizes_m.size() == ticks);
        double position_m = 0.0;
        for (std::int64_t tick = 0; tick < ticks; tick++) {
            position_m += sizes_m[static_cast<std::size_t>(tick)];
            REQUIRE(std::abs(position_m - walk_m(tick + 1)) < 2e-11);
        }
    }
}

TEST_CASE("robot: jitter is uniform within its bounds")
{
    REPRODUCIBLE();
    constexpr double jitter_ns = 800000.0;
    constexpr std::int64_t ticks = 20000;
    driven_robot driven({"robot.interpolation=hold", "robot.dead_time_ms=17.5", "robot.jitter_ms=0.8",
                         "run.seed=" + std::to_string(test_seed())});
    std::vector<double> shifts_ns;
    driven.on_event = [&](std::int64_t now_ns, double) {
        const auto tick = static_cast<std::int64_t>(shifts_ns.size());
        shifts_ns.push_back(static_cast<double>(now_ns - (tick * period_ns + 17500000)));
    };
    for (std::int64_t tick = 0; tick < ticks; tick++) {
        driven.send(tick, walk_m(tick + 1));
    }
    driven.run_until((ticks + 10) * period_ns);
    REQUIRE(shifts_ns.size() == ticks);
    double sum = 0.0;
    double squares = 0.0;
    for (const double shift_ns : shifts_ns) {
        CHECK(std::abs(shift_ns) <= jitter_ns);
        sum += shift_ns / jitter_ns;
        squares += shift_ns * shift_ns / (jitter_ns * jitter_ns);
    }
    /* Variance of a uniform draw 1/3, of its square 4/45; bounds of five standard deviations. */
    CHECK(std::abs(sum / ticks) < 5.0 * std::sqrt(1.0 / 3.0 / ticks));
    CHECK(std::abs(squares / ticks - 1.0 / 3.0) < 5.0 * std::sqrt(4.0 / 45.0 / ticks));
}

TEST_CASE("robot: after lost setpoints it rests at the last one, then goes on")
{
    driven_robot driven({"robot.dead_time_ms=10"});
    const auto is_lost = [](std::int64_t tick) { return tick >= 100 && tick < 110; };
    for (std::int64_t tick = 0; tick < 200; tick++) {
        driven.run_until(tick * period_ns);
        if (!is_lost(tick)) {
            driven.send(tick, walk_m(tick));
        }
        const std::int64_t passed = tick - 4;
        if (passed >= 0) {
            CHECK(std::abs(driven.position_m(tick * period_ns) - walk_m(is_lost(passed) ? 99 : passed)) < 2e-11);
        }
    }
}

TEST_CASE("robot: a setpoint that comes too late for its instant is not taken")
{
    driven_robot driven({"robot.dead_time_ms=10"});
    for (std::int64_t tick = 0; tick < 20; tick++) {
        driven.run_until(tick * period_ns);
        const hal_frame frame = setpoint_frame(tick, walk_m(tick));
        driven.get().receive(frame, frame.time_ns + (tick == 12 ? 10000001 : 10000000));
        if (tick >= 4) {
            const std::int64_t passed = tick - 4 == 12 ? 11 : tick - 4;
            CHECK(std::abs(driven.position_m(tick * period_ns) - walk_m(passed)) < 2e-11);
        }
    }
}

/* A clock that runs slow by d takes N d setpoints less than were sent: they are skipped. One that runs fast finds N
 * d times no new setpoint and stays at the old one. */
TEST_CASE("robot: its own clock slips against the loop's as often as theory says")
{
    for (const double drift_ppm : {-2000.0, -500.0, 0.0, 500.0, 2000.0}) {
        CAPTURE(drift_ppm);
        driven_robot driven({"robot.clock=free", "robot.clock_phase_ms=1.1",
                             "robot.clock_drift_ppm=" + std::to_string(drift_ppm), "robot.interpolation=hold",
                             "robot.dead_time_ms=17.5"});
        constexpr std::int64_t ticks = 40000;
        std::int64_t taken = 0;
        std::int64_t skipped = 0;
        int newest = -1;
        std::int64_t repeated = 0;
        std::int64_t latches = 0;
        std::int64_t next_latch_ns = 1100000;
        driven.on_event = [&](std::int64_t now_ns, double) {
            const double clock_period_ns = static_cast<double>(period_ns) * (1.0 + 1e-6 * drift_ppm);
            if (now_ns != next_latch_ns) {
                return;
            }
            latches++;
            next_latch_ns = std::llround(1.1e6 + clock_period_ns * static_cast<double>(latches));
            const int counter = driven.get().setpoint_counter();
            const int step = newest < 0 ? 1 : (counter - newest) & 0xff;
            taken += step > 0 ? 1 : 0;
            skipped += step > 1 ? step - 1 : 0;
            repeated += step == 0 ? 1 : 0;
            newest = counter;
        };
        for (std::int64_t tick = 0; tick < ticks; tick++) {
            driven.send(tick, walk_m(tick + 1));
        }
        driven.run_until(ticks * period_ns);
        const double slips = 1e-6 * drift_ppm * static_cast<double>(ticks);
        CHECK(std::abs(static_cast<double>(latches) - static_cast<double>(ticks) / (1.0 + 1e-6 * drift_ppm)) <= 1.0);
        CHECK(std::abs(static_cast<double>(skipped) - std::max(0.0, slips)) <= 1.0);
        CHECK(std::abs(static_cast<double>(repeated) - std::max(0.0, -slips)) <= 1.0);
        CHECK(taken + skipped >= ticks - 2);
    }
}

TEST_CASE("robot: velocity and acceleration limits are kept, and the setpoint is reached all the same")
{
    constexpr double velocity_limit = 0.2;
    constexpr double acceleration_limit = 3.0;
    driven_robot driven(
        {"robot.dead_time_ms=10", "robot.velocity_limit_m_per_s=0.2", "robot.acceleration_limit_m_per_s2=3"});
    std::vector<double> positions_m;
    for (std::int64_t tick = 0; tick < 1200; tick++) {
        driven.send(tick, tick < 10 ? 0.0 : tick < 600 ? 0.1 : -0.05); /* two steps */
        positions_m.push_back(driven.position_m(tick * period_ns));
    }
    double fastest = 0.0;
    double hardest = 0.0;
    for (std::size_t i = 2; i < positions_m.size(); i++) {
        const double velocity = (positions_m[i] - positions_m[i - 1]) / setpoint_period_s;
        const double before = (positions_m[i - 1] - positions_m[i - 2]) / setpoint_period_s;
        fastest = std::max(fastest, std::abs(velocity));
        hardest = std::max(hardest, std::abs(velocity - before) / setpoint_period_s);
    }
    CHECK(fastest <= velocity_limit * (1.0 + 1e-9));
    CHECK(fastest > 0.99 * velocity_limit);
    CHECK(hardest <= acceleration_limit * (1.0 + 1e-6));
    CHECK(hardest > 0.99 * acceleration_limit);
    CHECK(positions_m[599] == doctest::Approx(0.1).epsilon(1e-6));
    CHECK(positions_m[1199] == doctest::Approx(-0.05).epsilon(1e-6));
}

TEST_CASE("robot: a drive with limits does not stand still because a setpoint is lost")
{
    driven_robot driven(
        {"robot.dead_time_ms=10", "robot.acceleration_limit_m_per_s2=3", "robot.lost_command_probability=0.1"});
    std::vector<double> positions_m;
    for (std::int64_t tick = 0; tick < 1200; tick++) {
        driven.send(tick, 0.1 * std::sin(0.01 * static_cast<double>(tick)));
        positions_m.push_back(driven.position_m(tick * period_ns));
    }
    double hardest = 0.0;
    for (std::size_t i = 2; i < positions_m.size(); i++) {
        const double change_m = positions_m[i] - 2.0 * positions_m[i - 1] + positions_m[i - 2];
        hardest = std::max(hardest, std::abs(change_m) / (setpoint_period_s * setpoint_period_s));
    }
    CHECK(hardest > 0.99 * 3.0);
    CHECK(hardest <= 3.0 * (1.0 + 1e-6));
}

} // namespace berth
