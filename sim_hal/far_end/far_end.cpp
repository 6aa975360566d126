#include "far_end.h"

#include <sched.h>
#include <sys/mman.h>

#include <algorithm>

#include "../../firmware/can/berth_can.h"
#include "../../firmware/canopen.h"
#include "../../firmware/supervisor.h"
#include "../../hal/linux/hardware_error.h"
#include "../hil/side_hardware.h"

namespace berth
{

namespace
{

constexpr int wait_slice_ms = 100;

/* A loop that sends nothing for so long, not even its status, has ended. */
constexpr std::int64_t silence_ns = 3000000000;

/* Good to have: without it frames are late now and then, and that is counted. */
void become_real_time(std::int64_t priority)
{
    if (priority > 0) {
        mlockall(MCL_CURRENT | MCL_FUTURE);
        sched_param parameters{};
        parameters.sched_priority = static_cast<int>(priority);
        sched_setscheduler(0, SCHED_FIFO, &parameters);
    }
}

/* What the loop sends: setpoints first, its status last. */
std::vector<std::uint32_t> ids_of(const app_config &firmware)
{
    if (firmware.robot_channel.profile == ROBOT_PROFILE_BERTH) {
        std::vector<std::uint32_t> ids = {BERTH_CAN_SETPOINT_FRAME_ID, BERTH_CAN_LOOP_STATUS_FRAME_ID};
        for (std::uint32_t axis = 0; axis < SIDE_AXIS_COUNT; axis++) {
            if (firmware.side_axes[axis].enabled != 0) {
                ids.push_back(side_setpoint_id(axis));
            }
        }
        return ids;
    }
    const auto node = static_cast<std::uint32_t>(firmware.cia402.node_id);
    const auto master = static_cast<std::uint32_t>(firmware.cia402.master_node_id);
    return {CANOPEN_RPDO1_ID + node,
            CANOPEN_NMT_ID,
            CANOPEN_SYNC_ID,
            CANOPEN_SDO_REQUEST_ID + node,
            CANOPEN_HEARTBEAT_ID + master,
            BERTH_CAN_LOOP_STATUS_FRAME_ID};
}

void sleep_until(std::int64_t monotonic_ns)
{
    const timespec wanted = timespec_of(monotonic_ns);
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wanted, nullptr) == EINTR) {
    }
}

} // namespace

far_end::far_end(const berth::rig &rig, const far_end_options &options)
    : rig_(rig), options_(options), robot_bus_(HAL_BUS_ROBOT, options.robot_interface, ids_of(rig.firmware)),
      sensor_bus_(HAL_BUS_SENSOR, options.sensor_interface, {}), period_ns_(config_period_ns(&rig.firmware)),
      setpoint_id_(ids_of(rig.firmware).front())
{
}

/* Time 0 is the tick that the first frame of the loop came from. */
bool far_end::wait_for_loop(const std::atomic<bool> &stop)
{
    robot_bus_.flush();
    while (!stop) {
        robot_bus_.wait(wait_slice_ms);
        stamps_.update();
        robot_bus_.drain(stamps_);
        hal_frame frame;
        while (robot_bus_.receive(INT64_MAX, frame)) {
            if ((frame.flags & HAL_FRAME_ERROR) == 0) {
                zero_ns_ = frame.time_ns / period_ns_ * period_ns_;
                return true;
            }
        }
    }
    return false;
}

void far_end::receive()
{
    stamps_.update();
    robot_bus_.drain(stamps_);
    sensor_bus_.drain(stamps_);
    hal_frame frame;
    while (robot_bus_.receive(INT64_MAX, frame)) {
        if (frame.flags & HAL_FRAME_ERROR) {
            continue;
        }
        heard_ns_ = frame.time_ns;
        if (frame.id == BERTH_CAN_LOOP_STATUS_FRAME_ID) {
            berth_can_loop_status_t raw;
            loop_has_stopped_ |=
                berth_can_loop_status_unpack(&raw, frame.data, frame.length) >= 0 && raw.state == SUPERVISOR_STOPPED;
        }
        result_.setpoints += frame.id == setpoint_id_;
        const std::int64_t frame_ns = rig_.bus(HAL_BUS_ROBOT).frame_time_ns(frame.length);
        frame.time_ns = std::max(frame.time_ns - zero_ns_ - frame_ns, rig_.now_ns());
        rig_.receive_from_loop(frame);
    }
    while (sensor_bus_.receive(INT64_MAX, frame)) { /* error frames */
    }
}

void far_end::send(hal_bus bus, std::int64_t now_ns)
{
    hal_frame frame;
    while (rig_.bus(bus).receive(now_ns, frame)) {
        if ((frame.flags & HAL_FRAME_ERROR) == 0) {
            (bus == HAL_BUS_ROBOT ? robot_bus_ : sensor_bus_).send(frame);
        }
    }
}

/* The rig moves on only for a sample that it has not taken yet: a setpoint must not come behind its time. */
void far_end::send_forces_until(std::int64_t time_ns)
{
    can_bus &bus = rig_.bus(HAL_BUS_SENSOR);
    for (;;) {
        const std::int64_t next_sample_ns = rig_.force_sensor().next_arrival_ns();
        const std::int64_t due_ns = std::min(bus.next_arrival_ns(), next_sample_ns);
        if (due_ns >= time_ns) {
            return;
        }
        sleep_until(zero_ns_ + due_ns);
        if (due_ns == next_sample_ns) {
            receive();
            rig_.advance_to(due_ns);
        }
        send(HAL_BUS_SENSOR, due_ns);
    }
}

far_end_result far_end::run(const std::atomic<bool> &stop)
{
    become_real_time(options_.priority);
    if (!options_.waits_for_loop) {
        zero_ns_ = next_tick_ns(read_clock_ns(CLOCK_MONOTONIC), period_ns_);
    } else if (!wait_for_loop(stop)) {
        return result_;
    }
    heard_ns_ = zero_ns_;
    const std::int64_t lead_ns = std::min(1000 * options_.lead_us, period_ns_ / 2);
    for (std::int64_t period = 1; !stop && !loop_has_stopped_; period++) {
        const std::int64_t tick_ns = period * period_ns_;
        if (options_.waits_for_loop && zero_ns_ + tick_ns > heard_ns_ + silence_ns) {
            break;
        }
        send_forces_until(tick_ns - lead_ns);
        sleep_until(zero_ns_ + tick_ns - lead_ns);
        receive();
        rig_.advance_to(tick_ns);
        send(HAL_BUS_SENSOR, tick_ns);
        send(HAL_BUS_ROBOT, tick_ns);
        result_.periods++;
        result_.late_periods += read_clock_ns(CLOCK_MONOTONIC) > zero_ns_ + tick_ns;
    }
    result_.robot_bus = robot_bus_.counts();
    result_.sensor_bus = sensor_bus_.counts();
    return result_;
}

} // namespace berth
