#include "virtual_rig.h"

#include <algorithm>

#include "../../firmware/can/codec.h"

namespace berth
{

virtual_rig::virtual_rig(const rig &rig)
    : plant_(rig), solver_(make_solver(rig)), state_(plant_.at_rest(rig.firmware.manipulator.initial_position_m)),
      buses_{can_bus(rig.bus, HAL_BUS_ROBOT, rig.run.seed), can_bus(rig.bus, HAL_BUS_SENSOR, rig.run.seed)},
      robot_(rig), sensor_(rig), operator_station_(rig), period_ns_(config_period_ns(&rig.firmware))
{
}

void virtual_rig::integrate_to(std::int64_t time_ns)
{
    if (time_ns > now_ns_) {
        solver_->advance(state_, robot_.line(now_ns_), time_ns - now_ns_);
        now_ns_ = time_ns;
    }
}

void virtual_rig::advance_to(std::int64_t now_ns)
{
    for (;;) {
        const std::int64_t next_ns = std::min(
            {robot_.next_event_ns(), sensor_.next_sample_ns(), next_report_ns_, operator_station_.next_frame_ns()});
        if (next_ns > now_ns) {
            break;
        }
        integrate_to(next_ns);
        if (robot_.next_event_ns() == next_ns && !robot_.stops_next()) {
            move_reference();
        } else if (sensor_.next_sample_ns() == next_ns) {
            sensor_.sample(plant_.measured_force_N(state_, robot_.line(now_ns_)), buses_[HAL_BUS_SENSOR]);
        } else if (next_report_ns_ == next_ns) {
            report_robot_position();
        } else if (operator_station_.next_frame_ns() == next_ns) {
            operator_station_.send(buses_[HAL_BUS_ROBOT]);
        } else { /* the robot stops, unless the loop is about to send where to go on */
            if (next_ns == now_ns) {
                break;
            }
            move_reference();
        }
    }
    integrate_to(now_ns);
}

void virtual_rig::approach(std::int64_t now_ns)
{
    advance_to(now_ns - 1);
    integrate_to(now_ns);
}

void virtual_rig::move_reference()
{
    const double jump_m = robot_.handle_event();
    if (jump_m != 0.0) {
        plant_.apply_reference_jump(state_, jump_m);
    }
}

void virtual_rig::report_robot_position()
{
    next_report_ns_ += period_ns_;
    if (robot_is_silent_) {
        return;
    }
    bool saturated = false;
    const double position_m = plant_.robot_position_m(state_, robot_.line(now_ns_));
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

void virtual_rig::receive_from_loop(const hal_frame &frame)
{
    std::int64_t end_ns = 0;
    if (buses_[frame.bus].transmit(frame, frame.time_ns, &end_ns)) {
        robot_.receive(frame, end_ns);
    }
}

rig_truth virtual_rig::truth() const
{
    const reference_line line = robot_.line(now_ns_);
    return {plant_.robot_position_m(state_, line),
            plant_.robot_velocity_m_per_s(state_, line),
            state_(object_position),
            state_(object_velocity),
            plant_.spring_force_N(state_, line),
            plant_.measured_force_N(state_, line)};
}

} // namespace berth
