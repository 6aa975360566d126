#include "operator_station.h"

#include "../../firmware/can/codec.h"
#include "../../firmware/operator_command.h"
#include "../../firmware/supervisor.h"

namespace berth
{

operator_station::operator_station(const rig &rig)
    : profile_(rig), orders_(rig.orders), interface_(rig.firmware.operator_command.interface),
      bus_(static_cast<std::uint8_t>(rig.firmware.operator_command.bus)), release_s_(rig.run.release_s),
      period_ns_(config_period_ns(&rig.firmware))
{
}

hal_frame operator_station::motion_frame(const profile_point &point, std::uint8_t request)
{
    bool saturated = false;
    const double position_m = codec_saturate(point.value, CAN_OPERATOR_POSITION_MAX_m, &saturated);
    const double velocity_m_per_s = codec_saturate(point.rate, CAN_OPERATOR_VELOCITY_MAX_m_per_s, &saturated);
    berth_can_operator_motion_t raw{};
    raw.position_m = berth_can_operator_motion_position_m_encode(
        codec_round(position_m, berth_can_operator_motion_position_m_decode(1)));
    raw.velocity_m_per_s = berth_can_operator_motion_velocity_m_per_s_encode(
        codec_round(velocity_m_per_s, berth_can_operator_motion_velocity_m_per_s_decode(1)));
    raw.request = request;
    raw.counter = counter_;
    hal_frame frame{0, BERTH_CAN_OPERATOR_MOTION_FRAME_ID, bus_, BERTH_CAN_OPERATOR_MOTION_LENGTH, 0, 0, {}};
    berth_can_operator_motion_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

hal_frame operator_station::force_frame(const profile_point &point, std::uint8_t request)
{
    bool saturated = false;
    const double force_N = codec_saturate(point.value, CAN_FORCE_MAX_N, &saturated);
    berth_can_operator_force_t raw{};
    raw.force_n =
        berth_can_operator_force_force_n_encode(codec_round(force_N, berth_can_operator_force_force_n_decode(1)));
    raw.request = request;
    raw.counter = counter_;
    hal_frame frame{0, BERTH_CAN_OPERATOR_FORCE_FRAME_ID, bus_, BERTH_CAN_OPERATOR_FORCE_LENGTH, 0, 0, {}};
    berth_can_operator_force_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

hal_frame operator_station::order_frame(const arm_order &order)
{
    hal_frame frame{0, 0, bus_, 8, 0, 0, {}};
    if (order.kind == ARM_ORDER_LINE) {
        berth_can_operator_line_t raw{};
        const double step_m = berth_can_operator_line_x_m_decode(1);
        raw.x_m = berth_can_operator_line_x_m_encode(codec_round(order.way_m[0], step_m));
        raw.y_m = berth_can_operator_line_y_m_encode(codec_round(order.way_m[1], step_m));
        raw.z_m = berth_can_operator_line_z_m_encode(codec_round(order.way_m[2], step_m));
        raw.speed_m_per_s = berth_can_operator_line_speed_m_per_s_encode(
            codec_round(order.speed_m_per_s, berth_can_operator_line_speed_m_per_s_decode(1)));
        raw.counter = line_counter_++ & 0x0f;
        frame.id = BERTH_CAN_OPERATOR_LINE_FRAME_ID;
        berth_can_operator_line_pack(frame.data, &raw, sizeof frame.data);
        return frame;
    }
    berth_can_operator_joint_t raw{};
    raw.joint = static_cast<std::uint8_t>(order.joint);
    raw.order = order.kind == ARM_ORDER_JOINT_RATE   ? BERTH_CAN_OPERATOR_JOINT_ORDER_RATE_CHOICE
                : order.kind == ARM_ORDER_JOINT_MOVE ? BERTH_CAN_OPERATOR_JOINT_ORDER_MOVE_CHOICE
                                                     : BERTH_CAN_OPERATOR_JOINT_ORDER_FOLLOW_CHOICE;
    raw.rate_rad_per_s = berth_can_operator_joint_rate_rad_per_s_encode(
        codec_round(order.rate_rad_per_s, berth_can_operator_joint_rate_rad_per_s_decode(1)));
    raw.angle_rad = berth_can_operator_joint_angle_rad_encode(
        codec_round(order.angle_rad, berth_can_operator_joint_angle_rad_decode(1)));
    raw.counter = joint_counter_++ & 0x0f;
    frame.id = BERTH_CAN_OPERATOR_JOINT_FRAME_ID;
    berth_can_operator_joint_pack(frame.data, &raw, sizeof frame.data);
    return frame;
}

void operator_station::receive(const hal_frame &frame)
{
    berth_can_loop_status_t status;
    if (frame.id == BERTH_CAN_LOOP_STATUS_FRAME_ID &&
        berth_can_loop_status_unpack(&status, frame.data, frame.length) == 0) {
        loop_is_ready_ = status.state == SUPERVISOR_READY;
    }
}

/* Who has asked for as long as a new status takes, and still reads "ready", has asked too early. */
std::uint8_t operator_station::scheduled_request(std::int64_t now_ns, bool is_released)
{
    constexpr std::int64_t patience_ns = NS_PER_S / 10;
    if (!is_released) {
        return OPERATOR_NONE;
    }
    asked_since_ns_ = asked_since_ns_ < 0 ? now_ns : asked_since_ns_;
    if (loop_is_ready_ && now_ns - asked_since_ns_ > patience_ns) {
        asked_since_ns_ = -1;
        return OPERATOR_NONE;
    }
    return OPERATOR_RUN;
}

void operator_station::send(can_bus &bus)
{
    const std::int64_t now_ns = next_frame_ns_;
    next_frame_ns_ += period_ns_;
    if (is_silent_) {
        return;
    }
    const double since_release_s = static_cast<double>(now_ns) * 1e-9 - release_s_;
    const std::uint8_t scheduled = scheduled_request(now_ns, since_release_s >= 0.0);
    const auto request = request_override_ >= 0 ? static_cast<std::uint8_t>(request_override_) : scheduled;
    const profile_point point = profile_.at(since_release_s);
    bus.transmit_to_loop(
        interface_ == OPERATOR_INTERFACE_FORCE ? force_frame(point, request) : motion_frame(point, request), now_ns);
    counter_ = (counter_ + 1) & 0x0f;
    for (; next_order_ < orders_.size() && since_release_s >= orders_[next_order_].at_s; next_order_++) {
        bus.transmit_to_loop(order_frame(orders_[next_order_].order), now_ns);
    }
}

} // namespace berth
