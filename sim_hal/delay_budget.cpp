#include "delay_budget.h"

#include <algorithm>

#include "../firmware/inverse_filter.h"
#include "../firmware/pi.h"
#include "../firmware/sensor_layout.h"
#include "effects/effect.h"
#include "stability/scheduled_rig.h"

namespace berth
{

namespace
{

constexpr double ms_per_ns = 1e-6;
constexpr int frame_bytes = 8;

double robot_lag_ms(const rig &rig)
{
    const double transfer_ms = rig.has_transfer_behaviour() ? 2e3 * rig.robot.transfer_damping_ratio /
                                                                  (two_pi * rig.robot.transfer_frequency_Hz)
                                                            : 0.0;
    return transfer_ms + value_of(rig, "robot.lag_ms") + 1e3 * inverse_filter_delay_s(&rig.firmware);
}

} // namespace

std::vector<delay_part> delay_budget::parts() const
{
    return {{"robot", "robot_ms", robot_ms},
            {"hold", "hold_ms", hold_ms},
            {"bus", "bus_ms", bus_ms},
            {"sensor", "sensor_ms", sensor_ms},
            {"low-pass", "low_pass_ms", low_pass_ms},
            {"waiting for the tick", "wait_ms", wait_ms}};
}

delay_budget delay_budget_of(const rig &rig)
{
    const double period_ms = 1e3 * config_period_s(&rig.firmware);
    const double frame_ms = ms_per_ns * static_cast<double>(frame_time_ns(rig.bus, frame_bytes));
    const auto robot_frames = static_cast<double>(robot_frames_a_tick(rig));
    const double sensor_frames = sensor_layouts[rig.firmware.sensor_channel.layout].frame_count;
    const double setpoint_on_bus_ms = std::min(robot_frames * frame_ms, rig.robot.dead_time_ms);
    const double sample_on_bus_ms = std::min(sensor_frames * frame_ms, rig.sensor.delay_ms);
    const double sync_ms = ms_per_ns * static_cast<double>(sync_wait_ns(rig));
    const double sample_age_ms = ms_per_ns * static_cast<double>(rig.sample_age_ns());

    delay_budget budget;
    budget.robot_ms = rig.robot.dead_time_ms - setpoint_on_bus_ms + robot_lag_ms(rig);
    budget.hold_ms = 1e3 * config_force_hold_s(&rig.firmware) +
                     (rig.robot.interpolation == interpolation::hold ? 0.5 * period_ms : 0.0);
    budget.bus_ms = setpoint_on_bus_ms + sample_on_bus_ms;
    budget.sensor_ms = rig.sensor.delay_ms - sample_on_bus_ms + value_of(rig, "sensor.lag_ms");
    budget.low_pass_ms = 1e3 * rig.sensor_low_pass_delay_s();
    budget.wait_ms = sync_ms + sample_age_ms - rig.sensor.delay_ms;
    return budget;
}

std::vector<scheduled_delay> delays_of_schedule(const rig &rig)
{
    std::vector<scheduled_delay> found;
    if (!has_schedule(rig)) {
        return found;
    }
    double before_ms = delay_budget_of(rig).total_ms();
    for (const double at_s : instants_of_schedule(rig)) {
        const double total_ms = delay_budget_of(rig_at(rig, at_s)).total_ms();
        if (total_ms != before_ms) {
            found.push_back({at_s, total_ms});
        }
        before_ms = total_ms;
    }
    return found;
}

} // namespace berth
