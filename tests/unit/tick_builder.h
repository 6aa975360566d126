/* Frames and ticks as the outside world makes them: packed with the generated codec, rounded with the C library. */
#ifndef TESTS_UNIT_TICK_BUILDER_H
#define TESTS_UNIT_TICK_BUILDER_H

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "firmware/app.h"
#include "firmware/can/berth_can.h"

namespace bench
{

inline hal_frame frame_of(std::uint32_t id, hal_bus bus, std::int64_t time_ns)
{
    hal_frame frame{};
    frame.time_ns = time_ns;
    frame.id = id;
    frame.bus = static_cast<std::uint8_t>(bus);
    frame.length = 8;
    return frame;
}

inline hal_frame feedback_frame(double position_m, std::uint8_t counter, std::int64_t time_ns = 0,
                                bool fault = false, std::uint8_t setpoint_counter = 0)
{
    hal_frame frame = frame_of(BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID, HAL_BUS_ROBOT, time_ns);
    berth_can_robot_feedback_t raw{};
    raw.position_m = std::llround(position_m * 1e11);
    raw.fault = fault;
    raw.setpoint_counter = setpoint_counter;
    raw.counter = counter;
    berth_can_robot_feedback_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

inline hal_frame force_frame(double force_N, std::uint8_t counter, std::int64_t time_ns = 0, bool saturated = false)
{
    hal_frame frame = frame_of(BERTH_CAN_FORCE_FRAME_ID, HAL_BUS_SENSOR, time_ns);
    berth_can_force_t raw{};
    raw.force_n = std::llround(force_N * 1e7);
    raw.saturated = saturated;
    raw.counter = counter;
    berth_can_force_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

inline hal_frame motion_frame(double position_m, double velocity_m_per_s, int request, std::uint8_t counter,
                              std::int64_t time_ns = 0)
{
    hal_frame frame = frame_of(BERTH_CAN_OPERATOR_MOTION_FRAME_ID, HAL_BUS_ROBOT, time_ns);
    berth_can_operator_motion_t raw{};
    raw.position_m = static_cast<std::int32_t>(std::lround(position_m * 1e9));
    raw.velocity_m_per_s = static_cast<std::int32_t>(std::lround(velocity_m_per_s * 1e6));
    raw.request = static_cast<std::uint8_t>(request);
    raw.counter = counter & 0x0f;
    berth_can_operator_motion_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

inline hal_frame operator_force_frame(double force_N, int request, std::uint8_t counter, std::int64_t time_ns = 0)
{
    hal_frame frame = frame_of(BERTH_CAN_OPERATOR_FORCE_FRAME_ID, HAL_BUS_ROBOT, time_ns);
    berth_can_operator_force_t raw{};
    raw.force_n = std::llround(force_N * 1e7);
    raw.request = static_cast<std::uint8_t>(request);
    raw.counter = counter & 0x0f;
    berth_can_operator_force_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

/* Order for a joint, counted from 0. */
inline hal_frame joint_frame(int joint, int order, double rate_rad_per_s, double angle_rad, std::uint8_t counter)
{
    hal_frame frame = frame_of(BERTH_CAN_OPERATOR_JOINT_FRAME_ID, HAL_BUS_ROBOT, 0);
    berth_can_operator_joint_t raw{};
    raw.joint = static_cast<std::uint8_t>(joint);
    raw.order = static_cast<std::uint8_t>(order);
    raw.rate_rad_per_s = static_cast<std::int32_t>(std::lround(rate_rad_per_s * 1e6));
    raw.angle_rad = static_cast<std::int32_t>(std::lround(angle_rad * 1e6));
    raw.counter = counter & 0x0f;
    berth_can_operator_joint_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

inline hal_frame line_frame(double x_m, double y_m, double speed_m_per_s, std::uint8_t counter)
{
    hal_frame frame = frame_of(BERTH_CAN_OPERATOR_LINE_FRAME_ID, HAL_BUS_ROBOT, 0);
    berth_can_operator_line_t raw{};
    raw.x_m = static_cast<std::int16_t>(std::lround(x_m / 2e-4));
    raw.y_m = static_cast<std::int16_t>(std::lround(y_m / 2e-4));
    raw.speed_m_per_s = static_cast<std::uint16_t>(std::lround(speed_m_per_s * 1e3));
    raw.counter = counter & 0x0f;
    berth_can_operator_line_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

/* The reference manipulator, 10 mm off its rest: it moves as soon as it may. */
inline app_config moving_config()
{
    app_config config = config_default();
    config.manipulator.stiffness_N_per_m = 7895.6835208714865;
    config.manipulator.damping_N_s_per_m = 125.66370614359172;
    config.manipulator.initial_position_m = 0.01;
    return config;
}

/* An operator who asks to run only after the loop has been seen to be ready. */
class patient_operator
{
  public:
    /* The request for the next tick, of who wants `wanted` and sees `state`. */
    int asks(int wanted, supervisor_state state)
    {
        const bool must_wait = state == SUPERVISOR_START || (state == SUPERVISOR_READY && !was_ready_);
        was_ready_ = state == SUPERVISOR_READY;
        return wanted == OPERATOR_RUN && must_wait ? static_cast<int>(OPERATOR_NONE) : wanted;
    }

  private:
    bool was_ready_ = false;
};

/* A whole loop around one app: a robot that is always where it was sent, a sensor and an operator, each of which
 * can be made to fail from one tick to the next. */
class app_bench
{
  public:
    explicit app_bench(const app_config &config = moving_config())
        : app_(std::make_unique<struct app>()), period_ns_(config_period_ns(&config)),
          robot_position_m(config.manipulator.initial_position_m)
    {
        app_start(app_.get(), &config);
    }

    /* Builds the input of the next tick and steps the app. */
    void tick()
    {
        const std::int64_t now_ns = index_ * period_ns_;
        in_ = {};
        in_.tick = {index_, now_ns, now_ns, missed, stop};
        in_.enable = index_ > 0 ? enable : std::uint8_t{0};
        in_.emergency_stop = emergency_stop;
        in_.unsent_frames = unsent_frames_;
        if (has_feedback) {
            add(feedback_frame(robot_position_m, feedback_counter++, now_ns, robot_fault, echo_));
        }
        if (has_force) {
            add(force_frame(force_N, force_counter++, now_ns, saturated));
        }
        if (has_operator) {
            add(motion_frame(operator_position_m, 0.0,
                             waits_until_ready ? operator_.asks(request, state()) : request, operator_counter++,
                             now_ns));
        }
        for (const hal_frame &frame : extra) {
            add(frame);
        }
        app_step(app_.get(), &in_, &out_);
        if (refuses_frames) {
            unsent_frames_ += out_.frame_count;
        } else if (has_robot) {
            take_setpoint();
        }
        index_++;
    }

    void run(int ticks)
    {
        for (int i = 0; i < ticks; i++) {
            tick();
        }
    }

    /* What a person does before the loop may run again: takes the enable away and gives it. */
    void enable_anew()
    {
        enable = 0;
        tick();
        enable = 1;
        tick();
    }

    /* Ticks until `state` is reached; false if it is not within `ticks_max`. */
    bool run_until(supervisor_state state, int ticks_max = 400)
    {
        for (int i = 0; i < ticks_max && app_->supervisor.state != state; i++) {
            tick();
        }
        return app_->supervisor.state == state;
    }

    struct app &app() { return *app_; }
    supervisor_state state() const { return app_->supervisor.state; }
    stop_cause cause() const { return app_->supervisor.stop_cause; }
    const tick_input &in() const { return in_; }
    const tick_output &out() const { return out_; }
    std::int64_t now_ns() const { return index_ * period_ns_; } /* of the next tick */

  private:
    void add(hal_frame frame)
    {
        if (corrupt) {
            corrupt(frame);
        }
        in_.frames[in_.frame_count++] = frame;
    }

    void take_setpoint()
    {
        berth_can_setpoint_t raw{};
        robot_position_m = app_->recorder.tick.command_position_m;
        if (echoes && out_.frame_count > 0 && out_.frames[0].id == BERTH_CAN_SETPOINT_FRAME_ID &&
            berth_can_setpoint_unpack(&raw, out_.frames[0].data, 8) == 0) {
            echo_ = raw.counter;
        }
    }

    std::unique_ptr<struct app> app_;
    patient_operator operator_;
    std::uint8_t echo_ = 0; /* counter of the newest setpoint that the robot has taken */
    std::uint32_t unsent_frames_ = 0;
    std::int64_t period_ns_;
    std::int64_t index_ = 0;
    tick_input in_{};
    tick_output out_{};

  public: /* what the next tick is made of */
    double robot_position_m;
    double force_N = 0.0;
    double operator_position_m = 0.0;
    int request = OPERATOR_NONE;
    bool has_feedback = true, has_force = true, has_operator = true;
    bool has_robot = true;       /* the robot follows its setpoints */
    bool echoes = true;          /* and reports which it has */
    bool refuses_frames = false; /* the bus takes none */
    bool robot_fault = false, saturated = false;
    std::uint8_t enable = 1, emergency_stop = 0; /* enable: off in the first tick, whatever it is */
    bool waits_until_ready = true;               /* the operator, with the request to run */
    std::uint32_t missed = 0, stop = 0;
    std::uint8_t feedback_counter = 0, force_counter = 0, operator_counter = 0;
    std::vector<hal_frame> extra;
    std::function<void(hal_frame &)> corrupt; /* changes frames on their way */
};

} // namespace bench

#endif
