#include "side_hardware.h"

namespace berth
{

side_hardware::side_hardware(const rig &rig, std::size_t axis)
    : axis_(axis), robot_(rig_along(rig, axis), side_setpoint_id(axis)), plant_(rig_along(rig, axis), 0.0)
{
}

void side_hardware::travel_to(std::int64_t time_ns)
{
    if (time_ns > now_ns_) {
        plant_.advance(robot_.line(now_ns_), now_ns_, time_ns - now_ns_);
        now_ns_ = time_ns;
    }
}

void side_hardware::move_reference()
{
    const double jump = robot_.handle_event();
    if (jump != 0.0) {
        plant_.jump(jump);
    }
}

void side_hardware::advance_to(std::int64_t now_ns)
{
    for (;;) {
        const std::int64_t next_ns = robot_.next_event_ns();
        if (next_ns > now_ns || (next_ns == now_ns && robot_.stops_next())) {
            break;
        }
        travel_to(next_ns);
        move_reference();
    }
    travel_to(now_ns);
}

double side_hardware::robot_position() const
{
    return plant_.robot_position_m(robot_.line(now_ns_));
}

double side_hardware::measured_force() const
{
    return plant_.measured_force_N(robot_.line(now_ns_));
}

std::vector<std::unique_ptr<side_hardware>> make_side_hardware(const rig &rig)
{
    std::vector<std::unique_ptr<side_hardware>> made;
    for (std::size_t axis = 0; axis < SIDE_AXIS_COUNT; axis++) {
        if (rig.firmware.side_axes[axis].enabled != 0) {
            made.push_back(std::make_unique<side_hardware>(rig, axis));
        }
    }
    return made;
}

std::uint32_t side_setpoint_id(std::size_t axis)
{
    constexpr std::array<std::uint32_t, SIDE_AXIS_COUNT> ids = {
        BERTH_CAN_SETPOINT_Y_FRAME_ID, BERTH_CAN_SETPOINT_Z_FRAME_ID, BERTH_CAN_SETPOINT_RX_FRAME_ID,
        BERTH_CAN_SETPOINT_RY_FRAME_ID, BERTH_CAN_SETPOINT_RZ_FRAME_ID};
    return ids[axis];
}

std::uint32_t side_feedback_id(std::size_t axis)
{
    constexpr std::array<std::uint32_t, SIDE_AXIS_COUNT> ids = {
        BERTH_CAN_FEEDBACK_Y_FRAME_ID, BERTH_CAN_FEEDBACK_Z_FRAME_ID, BERTH_CAN_FEEDBACK_RX_FRAME_ID,
        BERTH_CAN_FEEDBACK_RY_FRAME_ID, BERTH_CAN_FEEDBACK_RZ_FRAME_ID};
    return ids[axis];
}

} // namespace berth
