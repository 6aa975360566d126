#include "deadtime.h"

#include <cmath>
#include <cstdint>

#include "../../firmware/can/codec.h"
#include "../../firmware/robot_channel.h"

namespace berth
{

namespace
{

/* Feedback settles before the step, and the setpoints fill the robot's queue. */
constexpr double settle_s = 0.5;

/* Reports that are still missing after so many times the ticks needed will not come. */
constexpr double patience = 20.0;

hal_frame setpoint_frame(double position_m, const hal_tick &tick)
{
    berth_can_setpoint_t raw{};
    raw.position_m =
        berth_can_setpoint_position_m_encode(codec_round(position_m, berth_can_setpoint_position_m_decode(1)));
    raw.motion_allowed = 1;
    raw.counter = static_cast<std::uint8_t>(tick.index);
    hal_frame frame{
        tick.scheduled_ns, BERTH_CAN_SETPOINT_FRAME_ID, HAL_BUS_ROBOT, BERTH_CAN_SETPOINT_LENGTH, 0, 0, {}};
    berth_can_setpoint_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

/* Robot position at each tick, by the tick at which it was measured: reports are numbered by their counter. */
class feedback_track
{
  public:
    void receive(const hal_frame &frame)
    {
        berth_can_robot_feedback_t raw;
        if (frame.id != BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID ||
            berth_can_robot_feedback_unpack(&raw, frame.data, frame.length) < 0) {
            return;
        }
        const auto skipped = static_cast<std::uint8_t>(raw.counter - static_cast<std::uint8_t>(positions_m.size()));
        const double position_m = berth_can_robot_feedback_position_m_decode(raw.position_m);
        positions_m.resize(positions_m.size() + skipped + 1u, position_m);
    }

    std::vector<double> positions_m;
};

/* The firmware's own channel to a drive, without the loop around it. */
class drive_master
{
  public:
    explicit drive_master(const app_config &config) : config_(config)
    {
        reception_start(&reception_, &config_);
        robot_channel_start(&channel_, &config_);
        supervisor_start(&supervisor_);
    }
    drive_master(const drive_master &) = delete; /* the channel points at the configuration */
    drive_master &operator=(const drive_master &) = delete;

    void receive(struct hal *hal, const hal_tick &tick)
    {
        reception_begin_tick(&reception_, tick.missed, tick.woke_ns);
        robot_channel_begin_tick(&channel_);
        hal_frame frame;
        while (hal_can_receive(hal, HAL_BUS_SENSOR, &frame) == HAL_OK) {
        }
        while (hal_can_receive(hal, HAL_BUS_ROBOT, &frame) == HAL_OK) {
            const received_message message = reception_check(&reception_, &frame);
            if (message != RECEIVED_NONE && robot_channel_receive(&channel_, message, &frame)) {
                reception_accept(&reception_, message, &frame);
            }
        }
        robot_channel_end_receive(&channel_, &reception_, tick.scheduled_ns);
        if (channel_.is_fresh) {
            supervisor_.state = SUPERVISOR_READY;
        }
    }

    bool follows() const { return channel_.follows; }
    double position_m() const { return channel_.position_m; }

    void send(struct hal *hal, const hal_tick &tick, double position_m)
    {
        const robot_command command{position_m, 0, 0, 0, 0, 1, {}};
        tick_output out{};
        robot_channel_send(&channel_, &supervisor_, &tick, &command, &out);
        for (std::uint32_t i = 0; i < out.frame_count; i++) {
            hal_can_send(hal, &out.frames[i]);
        }
    }

  private:
    app_config config_;
    struct reception reception_;
    struct robot_channel channel_;
    struct supervisor supervisor_;
};

/* Of the robot's positions at the ticks from the step on. */
void evaluate(const std::vector<double> &positions_m, double start_m, double step_m, double period_s,
              deadtime_measurement &result)
{
    result = {0.0, 0.0, {}};
    bool has_moved = false;
    for (const double position_m : positions_m) {
        const double share = (position_m - start_m) / step_m;
        has_moved = has_moved || std::abs(share) > 1e-3;
        result.step.push_back(share);
        result.command_to_motion_s += (1.0 - share) * period_s;
        result.first_motion_s += has_moved ? 0.0 : period_s;
    }
}

} // namespace

hal_status measure_deadtime(struct hal *hal, const app_config &config, double step_m, double watch_s,
                            deadtime_measurement &result)
{
    const double period_s = config_period_s(&config);
    const auto step_tick = static_cast<std::size_t>(settle_s / period_s);
    const std::size_t watch_ticks = static_cast<std::size_t>(watch_s / period_s);
    const double start_m = config.manipulator.initial_position_m;
    feedback_track track;
    hal_tick tick{};
    const auto ticks_max = static_cast<std::int64_t>(patience * static_cast<double>(step_tick + watch_ticks));
    while (track.positions_m.size() < step_tick + watch_ticks) {
        hal_status status = hal_wait_tick(hal, &tick);
        if (status != HAL_OK || tick.index > ticks_max) {
            return status != HAL_OK ? status : HAL_END;
        }
        hal_frame frame;
        while (hal_can_receive(hal, HAL_BUS_SENSOR, &frame) == HAL_OK) {
        }
        while (hal_can_receive(hal, HAL_BUS_ROBOT, &frame) == HAL_OK) {
            track.receive(frame);
        }
        const bool has_stepped = tick.index >= static_cast<std::int64_t>(step_tick);
        frame = setpoint_frame(has_stepped ? start_m + step_m : start_m, tick);
        status = hal_can_send(hal, &frame);
        if (status != HAL_OK) {
            return status;
        }
    }
    evaluate({track.positions_m.begin() + static_cast<std::ptrdiff_t>(step_tick), track.positions_m.end()}, start_m,
             step_m, period_s, result);
    return HAL_OK;
}

hal_status measure_drive_deadtime(struct hal *hal, const app_config &config, double step_m, double watch_s,
                                  deadtime_measurement &result)
{
    const double period_s = config_period_s(&config);
    const auto settle_ticks = static_cast<std::int64_t>(settle_s / period_s);
    const auto watch_ticks = static_cast<std::size_t>(watch_s / period_s);
    const double start_m = config.manipulator.initial_position_m;
    drive_master master(config);
    std::vector<double> positions_m;
    hal_tick tick{};
    std::int64_t step_tick = -1;
    while (positions_m.size() < watch_ticks) {
        const hal_status status = hal_wait_tick(hal, &tick);
        if (status != HAL_OK || tick.index > static_cast<std::int64_t>(patience) * (settle_ticks + 400)) {
            return status != HAL_OK ? status : HAL_END;
        }
        master.receive(hal, tick);
        if (step_tick < 0 && master.follows()) {
            step_tick = tick.index + settle_ticks;
        }
        const bool has_stepped = step_tick >= 0 && tick.index >= step_tick;
        if (step_tick >= 0 && tick.index > step_tick) {
            positions_m.push_back(master.position_m());
        }
        master.send(hal, tick, has_stepped ? start_m + step_m : start_m);
    }
    evaluate(positions_m, start_m, step_m, period_s, result);
    return HAL_OK;
}

} // namespace berth
