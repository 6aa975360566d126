#include "rig_events.h"

#include "../../firmware/can/codec.h"
#include "../effects/active.h"

namespace berth
{

rig_events::rig_events(const rig &rig)
    : buses_{can_bus(rig.bus, HAL_BUS_ROBOT, rig.run.seed), can_bus(rig.bus, HAL_BUS_SENSOR, rig.run.seed)},
      robot_(rig), sides_(make_side_hardware(rig)), sensor_(rig), operator_station_(rig),
      period_ns_(config_period_ns(&rig.firmware)), feedback_(rig.run.seed, stream_feedback),
      feedback_noise_m_(rig.robot.feedback_noise_m), lost_(rig.run.seed, stream_lost_samples),
      ticks_kept_(ns_from_ms(rig.sensor.delay_ms) / period_ns_ + 16),
      lost_probability_(value_of_effect(rig, "loop.lost_sample_probability"))
{
    if (rig.firmware.robot_channel.profile == ROBOT_PROFILE_CIA402) {
        drive_ = std::make_unique<cia402_drive>(rig, robot_, buses_[HAL_BUS_ROBOT]);
        next_report_ns_ = canopen_node::never_ns;
    }
}

/* Whether what arrives for this tick is lost as a whole. Reports and samples ask for different ticks at a time, so
 * what has been drawn is kept for a while. */
bool rig_events::is_tick_lost(std::int64_t tick)
{
    if (lost_probability_ == 0.0) {
        return false;
    }
    const auto kept = static_cast<std::int64_t>(tick_is_lost_.size());
    if (kept > 4 * ticks_kept_) {
        tick_is_lost_.erase(tick_is_lost_.begin(), tick_is_lost_.end() - ticks_kept_);
        first_known_tick_ += kept - ticks_kept_;
    }
    while (first_known_tick_ + static_cast<std::int64_t>(tick_is_lost_.size()) <= tick) {
        tick_is_lost_.push_back(lost_.happens(lost_probability_));
    }
    return tick >= first_known_tick_ && tick_is_lost_[static_cast<std::size_t>(tick - first_known_tick_)] != 0;
}

void rig_events::sample_force(double force_N)
{
    const std::int64_t tick = (sensor_.next_arrival_ns() + period_ns_ - 1) / period_ns_;
    sensor::whole_load load{force_N};
    for (const auto &side : sides_) {
        side->advance_to(now_ns_);
        load[1 + side->axis()] = side->measured_force();
    }
    sensor_.sample(load, buses_[HAL_BUS_SENSOR], is_tick_lost(tick));
}

void rig_events::report_robot_position(double position_m)
{
    next_report_ns_ = drive_ ? canopen_node::never_ns : next_report_ns_ + period_ns_;
    if (feedback_noise_m_ > 0.0) {
        position_m += feedback_noise_m_ * feedback_.normal();
    }
    const bool is_lost = !robot_is_silent_ && is_tick_lost(now_ns_ / period_ns_);
    if (!drive_) {
        report_counter_ += is_lost;
        if (!robot_is_silent_ && !is_lost) {
            send_feedback(BERTH_CAN_ROBOT_FEEDBACK_FRAME_ID, position_m, robot_.setpoint_counter(), report_counter_);
            for (const auto &side : sides_) {
                side->advance_to(now_ns_);
                send_feedback(side_feedback_id(side->axis()), side->robot_position(), side->setpoint_counter(),
                              report_counter_);
            }
            report_counter_++;
        }
    } else if (is_lost) {
        drive_->drop_samples();
    } else {
        drive_->set_position_m(position_m);
        drive_->send_samples();
    }
}

void rig_events::send_feedback(std::uint32_t id, double position, std::uint8_t setpoint_counter,
                               std::uint8_t counter)
{
    bool saturated = false;
    const double step = berth_can_robot_feedback_position_m_decode(1);
    berth_can_robot_feedback_t raw{};
    raw.position_m = berth_can_robot_feedback_position_m_encode(
        codec_round(codec_saturate(position, CAN_POSITION_MAX_m, &saturated), step));
    raw.fault = robot_has_fault_;
    raw.setpoint_counter = setpoint_counter;
    raw.counter = counter;
    hal_frame frame{0, id, HAL_BUS_ROBOT, BERTH_CAN_ROBOT_FEEDBACK_LENGTH, 0, 0, {}};
    if (berth_can_robot_feedback_pack(frame.data, &raw, sizeof frame.data) > 0) {
        buses_[HAL_BUS_ROBOT].transmit_to_loop(frame, now_ns_);
    }
}

void rig_events::receive_from_loop(const hal_frame &frame)
{
    std::int64_t end_ns = 0;
    if (!buses_[frame.bus].transmit(frame, frame.time_ns, &end_ns)) {
        return;
    }
    operator_station_.receive(frame);
    if (!drive_) {
        robot_.receive(frame, end_ns);
        for (const auto &side : sides_) {
            side->advance_to(now_ns_);
            side->receive(frame, end_ns);
        }
        return;
    }
    if (drive_->is_process_data(frame) && robot_.loses_command()) {
        return;
    }
    drive_->receive(frame, end_ns);
    next_report_ns_ = drive_->next_sample_ns();
}

void rig_events::set_robot_silent(bool silent)
{
    robot_is_silent_ = silent;
    if (drive_) {
        drive_->set_silent(silent);
    }
}

void rig_events::set_robot_fault(bool fault)
{
    robot_has_fault_ = fault;
    if (drive_) {
        drive_->set_fault(fault, now_ns_);
    }
}

} // namespace berth
