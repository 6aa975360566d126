#include "loop_timeline.h"

#include <cmath>
#include <memory>

#include "../../firmware/app.h"
#include "../../firmware/can/codec.h"
#include "../../firmware/canopen.h"
#include "../../hal/rig/rig_file.h"
#include "../effects/active.h"
#include "../hil/rig_events.h"
#include "../hil/setpoint_step.h"

namespace berth
{

namespace
{

/* The loop starts within this many ticks, whatever gets lost. */
constexpr std::int64_t start_ticks_max = 100000;

/* In steps of the wire, numbers pass unchanged through every frame. */
double number_step_N()
{
    return berth_can_force_force_n_decode(1);
}

std::int32_t number_of(double value, double step)
{
    return static_cast<std::int32_t>(std::llround(value / step));
}

/* Takes the place of the plant behind the events: writes down what it would have to do. */
struct timeline_writer {
    std::vector<timeline_step> &steps;
    double step_m;
    std::int32_t samples = 0;

    timeline_step step_on_line(timeline_step::kind what, const robot &robot, std::int64_t now_ns) const
    {
        const robot::course course = robot.course_now();
        const double line_s = static_cast<double>(course.to_ns - course.from_ns) * 1e-9;
        const double share_per_s = line_s > 0.0 ? 1.0 / line_s : 0.0;
        return {what,
                number_of(course.from_m, step_m),
                number_of(course.to_m, step_m),
                0,
                static_cast<double>(now_ns - course.from_ns) * 1e-9 * share_per_s,
                share_per_s};
    }
    void travel(const robot &robot, std::int64_t now_ns, std::int64_t duration_ns)
    {
        timeline_step step = step_on_line(timeline_step::kind::travel, robot, now_ns);
        step.duration_ns = duration_ns;
        const std::size_t count = steps.size();
        if (count > 0 && goes_on(steps[count - 1], step)) {
            steps[count - 1].duration_ns += duration_ns;
        } else if (count > 1 && steps[count - 1].what == timeline_step::kind::tick &&
                   goes_on(steps[count - 2], step)) { /* the tick changes nothing on the way, so it may go first */
            step = steps[count - 2];
            step.duration_ns += duration_ns;
            steps[count - 2] = steps[count - 1];
            steps[count - 1] = step;
        } else {
            steps.push_back(step);
        }
    }
    static bool goes_on(const timeline_step &before, const timeline_step &step)
    {
        return before.what == timeline_step::kind::travel && before.from == step.from && before.to == step.to &&
               before.share_per_s == step.share_per_s;
    }
    void jump(const robot &robot, double jump_m)
    {
        timeline_step step = step_on_line(timeline_step::kind::jump, robot, 0);
        step.from = step.to - number_of(jump_m, step_m);
        steps.push_back(step);
    }
    double measured_force_N(const robot &robot, std::int64_t now_ns)
    {
        steps.push_back(step_on_line(timeline_step::kind::sample, robot, now_ns));
        return ++samples * number_step_N();
    }
    double robot_position_m(const robot &robot, std::int64_t now_ns) const { return robot.line(now_ns).position_m; }
};

/* Nothing but what has to do with time. */
rig timing_of(const rig &original)
{
    constexpr double never_ms = 1e12;
    rig timing = without_effects_on_signals(original);
    timing.run.release_s = 0.0;
    timing.profile = {};
    timing.firmware.manipulator = config_default().manipulator;
    timing.firmware.manipulator.mass_kg = 1e12; /* stays where it is, whatever force the numbers make */
    timing.firmware.manipulator.initial_position_m = 0.0;
    timing.firmware.manipulator.initial_velocity_m_per_s = 0.0;
    timing.firmware.limits = config_default().limits;
    timing.firmware.inverse_filter.enabled = 0;
    timing.firmware.sensor_channel.layout = SENSOR_ONE_FRAME; /* which has room for the numbers */
    timing.firmware.sensor_channel.force_limit_N = CAN_FORCE_MAX_N;
    timing.firmware.sensor_channel.stale_after_ms = never_ms;
    timing.firmware.robot_channel.stale_after_ms = never_ms;
    timing.firmware.robot_channel.unsent_after_ms = never_ms;
    timing.firmware.robot_channel.setpoint_stale_after_ms = never_ms;
    timing.firmware.reflex = without_reflexes(timing.firmware.reflex); /* numbers are no motion */
    timing.firmware.operator_command.stale_after_ms = never_ms;
    timing.firmware.robot_channel.start_tolerance_m = 1.0;
    timing.firmware.cia402.counts_per_m = config_default().cia402.counts_per_m;
    timing.robot.velocity_limit_m_per_s = unlimited;
    timing.robot.acceleration_limit_m_per_s2 = unlimited;
    timing.sensor.bias_N = 0.0;
    timing.sensor.noise_N = 0.0;
    timing.sensor.resolution_N = 0.0;
    timing.sensor.saturation_N = unlimited;
    return timing;
}

/* The firmware with numbers for setpoints. */
class numbered_loop
{
  public:
    numbered_loop(const rig &timing, const wake_histogram &histogram)
        : app_(std::make_unique<struct app>()), config_(timing.firmware), events_(timing),
          lateness_(histogram, timing.run.seed), period_ns_(config_period_ns(&config_))
    {
        app_start(app_.get(), &config_);
        events_.operators().set_request(OPERATOR_NONE);
    }

    void tick(timeline_writer &writer)
    {
        const std::int64_t scheduled_ns = index_ * period_ns_;
        const std::int64_t woke_ns = scheduled_ns + lateness_.next_ns();
        events_.advance_to(woke_ns, writer);
        tick_input in{};
        tick_output out;
        in.tick = {index_, scheduled_ns, woke_ns, 0, 0};
        in.enable = HAL_LEVEL_NOT_WIRED;
        for (const hal_bus bus : {HAL_BUS_SENSOR, HAL_BUS_ROBOT}) {
            while (in.frame_count < TICK_FRAMES_IN_MAX &&
                   events_.bus(bus).receive(woke_ns, in.frames[in.frame_count])) {
                in.frame_count++;
            }
        }
        app_step(app_.get(), &in, &out);
        index_++;
        ready_ticks_ = app_->supervisor.state == SUPERVISOR_READY ? ready_ticks_ + 1 : 0;
        events_.operators().set_request(ready_ticks_ > 1 || is_running() ? OPERATOR_RUN : OPERATOR_NONE);
        for (std::uint32_t i = 0; i < out.frame_count; i++) {
            put_number(out.frames[i]);
            out.frames[i].time_ns = woke_ns;
            events_.receive_from_loop(out.frames[i]);
        }
    }

    bool is_running() const { return app_->supervisor.state == SUPERVISOR_RUNNING; }
    std::int32_t used_sample() const { return number_of(app_->sensor_channel.force_N, number_step_N()); }
    std::int32_t setpoints() const { return static_cast<std::int32_t>(index_); } /* so far, one a tick */

  private:
    /* In place of the position, if the frame is a setpoint. */
    void put_number(hal_frame &frame) const
    {
        if (config_.robot_channel.profile == ROBOT_PROFILE_CIA402) {
            if (frame.id == CANOPEN_RPDO1_ID + static_cast<std::uint32_t>(config_.cia402.node_id)) {
                canopen_put(frame.data + 2, static_cast<std::uint32_t>(setpoints()), 4);
            }
        } else if (frame.id == BERTH_CAN_SETPOINT_FRAME_ID) {
            berth_can_setpoint_t raw;
            berth_can_setpoint_unpack(&raw, frame.data, frame.length);
            raw.position_m = setpoints();
            berth_can_setpoint_pack(frame.data, &raw, sizeof frame.data);
        }
    }

    std::unique_ptr<struct app> app_;
    app_config config_;
    rig_events events_;
    wake_lateness lateness_;
    std::int64_t period_ns_;
    std::int64_t index_ = 0;
    int ready_ticks_ = 0;
};

/* How far back the steps look. */
std::int32_t memory_of(const loop_timeline &timeline)
{
    std::int32_t setpoint = timeline.first_setpoint - 1;
    std::int32_t sample = timeline.first_sample - 1;
    std::int32_t longest = 1;
    for (const timeline_step &step : timeline.steps) {
        if (step.what == timeline_step::kind::tick) {
            longest = std::max(longest, sample - step.from);
            setpoint++;
        } else {
            longest = std::max(longest, setpoint - std::min(step.from, step.to));
            sample += step.what == timeline_step::kind::sample;
        }
    }
    std::int32_t power = 1;
    while (power <= longest) {
        power *= 2;
    }
    return power;
}

bool loses_frames(const rig &rig)
{
    return rig.sensor.loss_probability > 0.0 || rig.sensor.stale_probability > 0.0 ||
           value_of_effect(rig, "robot.lost_command_probability") > 0.0 ||
           value_of_effect(rig, "loop.lost_sample_probability") > 0.0 || rig.bus.loss_probability > 0.0 ||
           rig.bus.burst_probability > 0.0 || rig.bus.error_probability > 0.0;
}

template <typename... values>
std::string words(const char *format, values... of)
{
    char text[200];
    std::snprintf(text, sizeof text, format, of...);
    return text;
}

} // namespace

loop_timeline make_timeline(const rig &rig, const wake_histogram &histogram, std::int64_t ticks)
{
    const berth::rig timing = timing_of(rig);
    numbered_loop loop(timing, histogram);
    loop_timeline timeline;
    timeline.ticks = ticks;
    timeline_writer writer{timeline.steps, setpoint_step_m(timing.firmware)};
    const auto tick = [&] {
        loop.tick(writer);
        timeline.steps.push_back({timeline_step::kind::tick, loop.used_sample(), 0, 0, 0.0, 0.0});
    };
    std::int64_t waited = 0;
    for (tick(); !loop.is_running(); tick()) {
        timeline.steps.clear();
        if (waited++ > start_ticks_max) {
            throw input_error("the loop never comes to run: too much is lost on its buses");
        }
    }
    timeline.steps.erase(timeline.steps.begin(), timeline.steps.end() - 1);
    timeline.steps.reserve(static_cast<std::size_t>(ticks) * 6);
    timeline.first_setpoint = loop.setpoints();
    timeline.first_sample = writer.samples + 1;
    for (std::int64_t i = 1; i < ticks; i++) {
        tick();
    }
    timeline.memory = memory_of(timeline);
    return timeline;
}

bool is_time_varying(const rig &rig)
{
    return rig.robot.clock == robot_clock::free || rig.robot.jitter_ms > 0.0 || !rig.run.lateness_file.empty() ||
           rig.has_wandering_samples() || loses_frames(rig);
}

std::vector<std::string> what_varies(const rig &rig, const wake_histogram &histogram)
{
    std::vector<std::string> effects;
    if (!histogram.lateness_ns.empty()) {
        effects.push_back(words("the loop wakes late by %g to %g us, %.4g us in the mean (%s)",
                                1e-3 * static_cast<double>(histogram.lateness_ns.front()),
                                1e-3 * static_cast<double>(histogram.max_ns()), 1e-3 * histogram.mean_ns,
                                rig.run.lateness_file.c_str()));
        if (const std::string note = left_out_note(histogram); !note.empty()) {
            effects.push_back(note);
        }
    }
    if (rig.robot.clock == robot_clock::free) {
        effects.push_back(words("the robot takes setpoints by a clock of its own, %g ms late, drifting by %g ppm",
                                rig.robot.clock_phase_ms, rig.robot.clock_drift_ppm));
    }
    if (rig.robot.jitter_ms > 0.0) {
        effects.push_back(words("the robot passes setpoints up to %g ms early or late", rig.robot.jitter_ms));
    }
    if (rig.has_wandering_samples()) {
        effects.push_back(words(
            "the sensor samples every %.0f ns (%g Hz), which does not go into the loop's period of %.0f ns (%g Hz)",
            static_cast<double>(config_sample_period_ns(&rig.firmware)), rig.sensor.rate_Hz,
            static_cast<double>(config_period_ns(&rig.firmware)), rig.firmware.loop.rate_Hz));
    }
    if (loses_frames(rig)) {
        if (rig.firmware.sensor_channel.layout != SENSOR_ONE_FRAME) {
            effects.emplace_back("neglected: a sample is taken to be lost as one frame, it has several");
        }
        effects.push_back("frames are lost, delayed or stale, see [bus] and [sensor]");
    }
    return effects;
}

rig without_variation(const rig &original)
{
    rig steady = original;
    steady.run.lateness_file.clear();
    steady.robot.clock = robot_clock::locked;
    steady.robot.jitter_ms = 0.0;
    if (original.has_wandering_samples()) {
        steady.sensor.rate_Hz = 0.0;
        steady.firmware.sensor_channel.rate_Hz = 0.0;
    }
    steady.sensor.loss_probability = 0.0;
    steady.sensor.stale_probability = 0.0;
    steady.bus.loss_probability = 0.0;
    steady.bus.burst_probability = 0.0;
    steady.bus.error_probability = 0.0;
    set_number(steady, "robot.lost_command_probability", 0.0);
    set_number(steady, "loop.lost_sample_probability", 0.0);
    return steady;
}

} // namespace berth
