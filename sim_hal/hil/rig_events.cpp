#include "rig_events.h"

#include "../../firmware/can/codec.h"

namespace berth
{

rig_events::rig_events(const rig &rig)
    : buses_{can_bus(rig.bus, HAL_BUS_ROBOT, rig.run.seed), can_bus(rig.bus, HAL_BUS_SENSOR, rig.run.seed)},
      robot_(rig), sensor_(rig), operator_station_(rig), period_ns_(config_period_ns(&rig.firmware))
{
}

void rig_events::report_robot_position(double position_m)
{
    if (robot_is_silent_) {
        return;
    }
    bool saturated = false;
    const double step_m = berth_can_robot_feedback_position_m_decode(1);
    berth_can_robot_feedback_t raw{};
    raw.position_m = berth_can_robot_feedback_position_m_encode(
        codec_round(codec_saturate(position_m, CAN_POSITION_MAX_m, &saturated), step_m));
    raw.fault = robot_has_fault_;
    raw.setpoint_counter = robot_.setpoint_counter();
    raw.counter = report_counter_++;
    hal_frame frame{0, BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID, HAL_BUS_ROBOT, BERTH_CAN_ROBOT_FEEDBACK_LENGTH, 0, 0, {}};
    if (berth_can_robot_feedback_pack(frame.data, &raw, sizeof frame.data) > 0) {
        buses_[HAL_BUS_ROBOT].transmit_to_loop(frame, now_ns_);
    }
}

void rig_events::receive_from_loop(const hal_frame &frame)
{
    std::int64_t end_ns = 0;
    if (buses_[frame.bus].transmit(frame, frame.time_ns, &end_ns)) {
        robot_.receive(frame, end_ns);
    }
}

} // namespace berth
