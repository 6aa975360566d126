/* What goes wrong while the arm moves on several axes at once, and the way back: all axes stop together and within
 * their limits, the arm waits where they stop, and goes on from there. */
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>

#include "hal/rig/arm_file.h"
#include "sim_hal/arm/urdf.h"
#include "tests/support/closed_loop.h"
#include "tests/support/files.h"

using namespace berth;

namespace
{

using tampering = std::function<bool(hal_frame &)>; /* with a frame to the loop; false: it does not arrive */

constexpr std::size_t axis_count = 1 + SIDE_AXIS_COUNT; /* x first */
using pose = std::array<double, axis_count>;

constexpr double wire_step = 1e-11;

/* A tenth of what the robot may: as joints set out that are led back to where the operator wants the tool. */
constexpr double gently_m_per_s2 = 5.0;

class watched_loop
{
  public:
    explicit watched_loop(const rig &rig)
        : rig_(rig), app_(std::make_unique<struct app>()), hal_(sim_open(rig, {"", {}, nullptr}))
    {
        app_start(app_.get(), &rig_.firmware);
    }
    watched_loop(const watched_loop &) = delete;
    watched_loop &operator=(const watched_loop &) = delete;
    ~watched_loop() { hal_close(hal_); }

    void tick()
    {
        tick_input in{};
        REQUIRE(hal_wait_tick(hal_, &in.tick) == HAL_OK);
        for (const hal_bus bus : {HAL_BUS_SENSOR, HAL_BUS_ROBOT}) {
            hal_frame frame{};
            while (hal_can_receive(hal_, bus, &frame) == HAL_OK) {
                if (!tamper || tamper(frame)) {
                    in.frames[in.frame_count++] = frame;
                }
            }
        }
        in.enable = HAL_LEVEL_NOT_WIRED;
        in.emergency_stop = emergency_stop;
        app_step(app_.get(), &in, &out_);
        for (std::uint32_t i = 0; i < out_.frame_count; i++) {
            hal_can_send(hal_, &out_.frames[i]);
        }
        check_setpoints();
        check_leave_to_move();
    }
    void run_to(double time_s)
    {
        while (static_cast<double>(app_->recorder.tick.scheduled_ns) * 1e-9 < time_s) {
            tick();
        }
    }
    bool run_until(supervisor_state state, int ticks_max = 800)
    {
        for (int i = 0; i < ticks_max && app_->supervisor.state != state; i++) {
            last_sent_ = sent();
            last_speed_ = speed_;
            tick();
        }
        return app_->supervisor.state == state;
    }

    /* Where the arm has the tool, in the robot's frame. */
    pose wanted() const
    {
        pose at{app_->manipulator.position_m};
        std::copy_n(app_->manipulator.arm.side, SIDE_AXIS_COUNT, at.begin() + 1);
        return at;
    }
    pose sent() const
    {
        pose at{app_->recorder.tick.command_position_m};
        std::copy_n(app_->robot_channel.side_sent, SIDE_AXIS_COUNT, at.begin() + 1);
        return at;
    }
    pose last_sent() const { return last_sent_; }    /* before the tick in which run_until() came to an end */
    pose last_speeds() const { return last_speed_; } /* and how fast */
    pose speeds() const { return speed_; }
    bool has(std::size_t axis) const { return axis == 0 || rig_.firmware.side_axes[axis - 1].enabled != 0; }
    const struct app &app() const { return *app_; }
    operator_station &operators() { return sim_rig(hal_).operators(); }
    bool is_at_rest() const { return limits_at_rest(&app_->limits) && side_axes_at_rest(&app_->side_axes); }

    tampering tamper;
    std::uint8_t emergency_stop = 0;

    const limits_config &limits_of(std::size_t axis) const
    {
        return axis == 0 ? rig_.firmware.limits : rig_.firmware.side_axes[axis - 1].limits;
    }

  private:
    /* In every tick of every test: nothing ever jumps beyond the limits. */
    void check_setpoints()
    {
        const double period_s = config_period_s(&rig_.firmware);
        const pose now = sent();
        for (std::size_t axis = 0; axis < axis_count; axis++) {
            const double speed = (now[axis] - before_[axis]) / period_s;
            const limits_config &limits = limits_of(axis);
            CAPTURE(axis);
            CAPTURE(app_->recorder.tick.index);
            if (has(axis)) {
                REQUIRE(std::abs(speed) <= limits.velocity_m_per_s + 2.0 * wire_step / period_s);
                REQUIRE(std::abs(speed - speed_[axis]) / period_s <=
                        limits.acceleration_m_per_s2 + 4.0 * wire_step / (period_s * period_s));
            } else {
                REQUIRE(now[axis] == 0.0);
            }
            speed_[axis] = speed;
        }
        before_ = now;
    }
    void check_leave_to_move() const
    {
        for (std::uint32_t i = 0; i < out_.frame_count; i++) {
            berth_can_setpoint_t raw{};
            if (out_.frames[i].id != BERTH_CAN_LOOP_STATUS_FRAME_ID) { /* all setpoints are laid out alike */
                REQUIRE(berth_can_setpoint_unpack(&raw, out_.frames[i].data, 8) == 0);
                REQUIRE(raw.motion_allowed == (app_->supervisor.state == SUPERVISOR_RUNNING));
            }
        }
    }

    rig rig_;
    std::unique_ptr<struct app> app_;
    struct hal *hal_;
    tick_output out_{};
    pose before_{};
    pose speed_{};
    pose last_sent_{};
    pose last_speed_{};
};

bool is_from_sensor(std::uint32_t id)
{
    return id >= BERTH_CAN_WRENCH3M_X_FRAME_ID && id <= BERTH_CAN_WRENCH3M_Z_FRAME_ID;
}

tampering without(std::uint32_t id)
{
    return [=](const hal_frame &frame) { return frame.id != id; };
}

tampering with_fault(std::uint32_t id)
{
    return [=](hal_frame &frame) {
        if (frame.id == id) {
            berth_can_robot_feedback_t raw{};
            REQUIRE(berth_can_robot_feedback_unpack(&raw, frame.data, frame.length) == 0);
            raw.fault = 1;
            REQUIRE(berth_can_robot_feedback_pack(frame.data, &raw, sizeof frame.data) > 0);
        }
        return true;
    };
}

struct trouble {
    std::string name;
    tampering tamper;
    bool is_emergency_stop;
    supervisor_state state;
    stop_cause cause;
};

std::vector<trouble> all_troubles()
{
    return {
        {"x reports a fault", with_fault(BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID), false, SUPERVISOR_FAULT,
         STOP_ROBOT_FAULT},
        {"y reports a fault", with_fault(BERTH_CAN_FEEDBACK_Y_FRAME_ID), false, SUPERVISOR_FAULT, STOP_ROBOT_FAULT},
        {"rz reports a fault", with_fault(BERTH_CAN_FEEDBACK_RZ_FRAME_ID), false, SUPERVISOR_FAULT,
         STOP_ROBOT_FAULT},
        {"x is not heard of", without(BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID), false, SUPERVISOR_FAULT,
         STOP_FEEDBACK_STALE},
        {"y is not heard of", without(BERTH_CAN_FEEDBACK_Y_FRAME_ID), false, SUPERVISOR_FAULT, STOP_FEEDBACK_STALE},
        {"rz is not heard of", without(BERTH_CAN_FEEDBACK_RZ_FRAME_ID), false, SUPERVISOR_FAULT,
         STOP_FEEDBACK_STALE},
        {"the sensor is silent", [](const hal_frame &frame) { return !is_from_sensor(frame.id); }, false,
         SUPERVISOR_HOLDING, STOP_SENSOR_STALE},
        {"one of the sensor's frames is lost", without(BERTH_CAN_WRENCH3M_Y_FRAME_ID), false, SUPERVISOR_HOLDING,
         STOP_SENSOR_STALE},
        {"the operator is silent", without(BERTH_CAN_OPERATOR_MOTION_FRAME_ID), false, SUPERVISOR_HOLDING,
         STOP_OPERATOR_STALE},
        {"emergency stop", {}, true, SUPERVISOR_FAULT, STOP_EMERGENCY_STOP},
    };
}

/* The arm as it is, joints, motors and satellite: what must not change while it waits. */
arm_record shape(const watched_loop &loop)
{
    arm_record record{};
    arm_motion_record(&loop.app().manipulator.arm, &record);
    record.timestamp = 0;
    return record;
}

bool same(const arm_record &a, const arm_record &b)
{
    bool is_same = true;
#define COMPARE(type, name) is_same = is_same && a.name == b.name;
    ARM_RECORD_FIELDS(COMPARE)
#undef COMPARE
    return is_same;
}

/* The way back that an operator goes: reset out of a fault, then run. */
void lead_back(watched_loop &loop, supervisor_state from)
{
    if (from == SUPERVISOR_FAULT) {
        loop.operators().set_request(OPERATOR_RESET);
        REQUIRE(loop.run_until(SUPERVISOR_READY));
    } else {
        loop.operators().set_request(OPERATOR_NONE);
        REQUIRE(loop.run_until(SUPERVISOR_READY));
    }
    loop.operators().set_request(OPERATOR_RUN);
    REQUIRE(loop.run_until(SUPERVISOR_RUNNING));
}

void check_near(const watched_loop &loop, const pose &a, const pose &b, double distance)
{
    for (std::size_t axis = 0; axis < axis_count; axis++) {
        CAPTURE(axis);
        if (loop.has(axis)) {
            CHECK(std::abs(a[axis] - b[axis]) < distance);
        }
    }
}

/* Every axis has gone on in its direction of motion by what braking takes, and never turned back. */
void check_brakes(const watched_loop &loop, const pose &at, pose &furthest)
{
    for (std::size_t axis = 0; axis < axis_count; axis++) {
        CAPTURE(axis);
        if (loop.has(axis)) {
            const double speed = loop.last_speeds()[axis];
            const double braking = 0.5 * speed * speed / loop.limits_of(axis).acceleration_m_per_s2;
            const double way = std::copysign(1.0, speed) * (at[axis] - loop.last_sent()[axis]);
            REQUIRE(way >= furthest[axis] - 2.0 * wire_step);
            REQUIRE(way <= braking + 2.0 * wire_step);
            furthest[axis] = std::max(furthest[axis], way);
        }
    }
}

/* Setpoints that fall behind an arm that is faster than the robot may be. */
rig slow_robot()
{
    rig slow = load_rig("ess-pose");
    slow.firmware.limits.velocity_m_per_s = 0.006;
    slow.firmware.side_axes[SIDE_AXIS_Y].limits.velocity_m_per_s = 0.003;
    slow.firmware.side_axes[SIDE_AXIS_RZ].limits.velocity_m_per_s = 0.001;
    return slow;
}

#ifdef BERTH_WITH_URDF
/* Seven joints in space and the robot's six axes, of dead times from the shortest to a long one; one joint turns. */
rig six_axes()
{
    const temporary_folder folder;
    const std::string urdf = "tests/arms/seven.urdf";
    arm_description arm = arm_from_urdf(read_bytes(urdf), urdf, {"", "gripper", false});
    constexpr std::array angles_rad = {0.3, 0.6, -0.4, -1.2, 0.5, 0.9, 0.2};
    for (std::size_t i = 0; i < angles_rad.size(); i++) {
        arm.config.joints[i].initial_rad = angles_rad[i];
    }
    std::ofstream(folder / "seven.toml") << print_arm(arm);
    std::ofstream(folder / "six.toml") << R"(
[manipulator]
arm = ")" << folder / "seven.toml"
                                       << R"("
direction_x = 1.0
[limits]
velocity_m_per_s = 0.5
[robot]
dead_time_ms = 17.5
[sensor_channel]
layout = "three_frames_motorola"
[object]
mass_kg = 0.5
[axis.y]
mass_kg = 0.5
robot_dead_time_ms = 2.5
[axis.z]
mass_kg = 0.5
robot_dead_time_ms = 100.0
[axis.rx]
inertia_kg_m2 = 0.01
[axis.ry]
inertia_kg_m2 = 0.01
robot_dead_time_ms = 100.0
[axis.rz]
inertia_kg_m2 = 0.01
robot_dead_time_ms = 2.5
[[orders]]
at_s = 0.5
joint = 3
rate_rad_per_s = 0.05
)";
    return load_rig(folder / "six.toml");
}
#endif

struct moment {
    std::string name;
    berth::rig rig;
    double time_s;
};

std::vector<moment> moments()
{
    return {
#ifdef BERTH_WITH_URDF
        {"six axes", six_axes(), 3.0},
#endif
        {"along a line", load_rig("ess-pose"), 3.0},
        {"by a joint", load_rig("ess-pose"), 15.0},
        {"by a joint faster than the robot", slow_robot(), 3.0},
        {"before the grip", load_rig("ess-berthing-pose"), 6.0},
        {"after the grip", load_rig("ess-berthing-pose"), 27.0}};
}

} // namespace

TEST_CASE("axes in trouble: all stop together, the arm waits where they stop, and goes on from there")
{
    for (const moment &when : moments()) {
        for (const trouble &trouble : all_troubles()) {
            CAPTURE(when.name);
            CAPTURE(trouble.name);
            watched_loop loop(when.rig);
            loop.run_to(when.time_s);
            REQUIRE(loop.app().supervisor.state == SUPERVISOR_RUNNING);
            for (std::size_t axis = 0; axis < axis_count; axis++) {
                REQUIRE((!loop.has(axis) || std::abs(loop.speeds()[axis]) > 1e-5)); /* there is motion to stop */
            }
            loop.tamper = trouble.tamper;
            loop.emergency_stop = trouble.is_emergency_stop;
            REQUIRE(loop.run_until(trouble.state, 100));
            CHECK(loop.app().supervisor.stop_cause == trouble.cause);

            const arm_record waiting = shape(loop);
            const pose rest = loop.wanted();
            pose furthest{};
            for (int i = 0; i < 400; i++) {
                check_brakes(loop, loop.sent(), furthest);
                loop.tick();
                REQUIRE(loop.app().supervisor.state == trouble.state);
                REQUIRE(same(shape(loop), waiting));
                REQUIRE(loop.wanted() == rest);
            }
            REQUIRE(loop.is_at_rest());
            check_near(loop, rest, loop.sent(), 2.0 * wire_step);

            loop.tamper = {};
            loop.emergency_stop = 0;
            lead_back(loop, trouble.state);
            check_near(loop, rest, loop.sent(), 1e-6);
            for (int i = 1; i <= 8; i++) {
                loop.tick();
                const double since_s = 2.5e-3 * i;
                check_near(loop, rest, loop.sent(), 1e-6 + 0.5 * gently_m_per_s2 * since_s * since_s);
            }
            for (int i = 0; i < 400; i++) {
                loop.tick();
                REQUIRE(loop.app().supervisor.state == SUPERVISOR_RUNNING);
            }
            CHECK(!same(shape(loop), waiting));
        }
    }
}

TEST_CASE("axes in trouble: an operator who cannot wait waits for the axis that takes longest to stop")
{
    for (const std::size_t slow : {SIDE_AXIS_Y, SIDE_AXIS_RZ}) {
        CAPTURE(slow);
        rig rig = load_rig("ess-pose");
        constexpr double slow_m_per_s2 = 0.02;
        rig.firmware.side_axes[slow].limits.acceleration_m_per_s2 = slow_m_per_s2;
        watched_loop loop(rig);
        loop.run_to(3.0);
        loop.tamper = with_fault(BERTH_CAN_FEEDBACK_RZ_FRAME_ID);
        REQUIRE(loop.run_until(SUPERVISOR_FAULT, 4));
        loop.tamper = {};
        const double speed = loop.speeds()[1 + slow]; /* that is left to be braked */
        loop.tick(); /* a reset counts only after the loop saw, in fault, that nobody asks for it */
        loop.operators().set_request(OPERATOR_RESET);
        int ticks = 0;
        bool was_at_rest = false;
        for (; loop.app().supervisor.state == SUPERVISOR_FAULT && ticks < 800; ticks++) {
            was_at_rest = loop.is_at_rest();
            loop.tick();
        }
        CHECK(ticks > 5);
        CHECK(ticks + 1 >= std::abs(speed) / (slow_m_per_s2 * config_period_s(&rig.firmware)));
        CHECK(was_at_rest);
        REQUIRE(loop.run_until(SUPERVISOR_READY));
    }
}

TEST_CASE("axes in trouble: a robot that has gone elsewhere along one axis is not moved")
{
    for (const std::uint32_t id : {BERTH_CAN_FEEDBACK_Y_FRAME_ID, BERTH_CAN_FEEDBACK_RZ_FRAME_ID}) {
        CAPTURE(id);
        watched_loop loop(load_rig("ess-pose"));
        loop.run_to(3.0);
        loop.emergency_stop = 1;
        REQUIRE(loop.run_until(SUPERVISOR_FAULT, 4));
        for (int i = 0; i < 100; i++) {
            loop.tick();
        }
        loop.emergency_stop = 0;
        loop.tamper = [=](hal_frame &frame) {
            berth_can_robot_feedback_t raw{};
            if (frame.id == id) {
                berth_can_robot_feedback_unpack(&raw, frame.data, frame.length);
                raw.position_m += 300000000; /* 3 mm, or 3 mrad */
                berth_can_robot_feedback_pack(frame.data, &raw, sizeof frame.data);
            }
            return true;
        };
        loop.operators().set_request(OPERATOR_RESET);
        REQUIRE(loop.run_until(SUPERVISOR_START));
        const pose rest = loop.wanted();
        CHECK(!loop.run_until(SUPERVISOR_READY));
        loop.tamper = {};
        REQUIRE(loop.run_until(SUPERVISOR_READY));
        loop.tick();
        loop.operators().set_request(OPERATOR_RUN);
        REQUIRE(loop.run_until(SUPERVISOR_RUNNING));
        check_near(loop, rest, loop.sent(), 1e-6);
    }
}

TEST_CASE("axes in trouble: the end of one axis' range stops all of them")
{
    rig rig = load_rig("ess-pose");
    limits_config &y = rig.firmware.side_axes[SIDE_AXIS_Y].limits;
    y.position_max_m = 0.002;
    y.position_min_m = -0.002;
    watched_loop loop(rig);
    REQUIRE(loop.run_until(SUPERVISOR_FAULT, 4000));
    CHECK(loop.app().supervisor.stop_cause == STOP_POSITION_LIMIT);
    const arm_record waiting = shape(loop);
    for (int i = 0; i < 400; i++) {
        loop.tick();
        REQUIRE(std::abs(loop.sent()[1]) <= 0.002 + wire_step);
        REQUIRE(same(shape(loop), waiting));
    }
    REQUIRE(loop.is_at_rest());
    lead_back(loop, SUPERVISOR_FAULT);
    CHECK(std::abs(loop.wanted()[1]) <= 0.002 + 1e-4);
}
