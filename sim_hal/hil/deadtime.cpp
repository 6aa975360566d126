#include "deadtime.h"

#include <cmath>
#include <cstdint>

#include "../../firmware/can/codec.h"

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
    result = {0.0, 0.0, {}};
    bool has_moved = false;
    for (std::size_t i = step_tick; i < track.positions_m.size(); i++) {
        const double share = (track.positions_m[i] - start_m) / step_m;
        has_moved = has_moved || std::abs(share) > 1e-3;
        result.step.push_back(share);
        result.command_to_motion_s += (1.0 - share) * period_s;
        result.first_motion_s += has_moved ? 0.0 : period_s;
    }
    return HAL_OK;
}

} // namespace berth
