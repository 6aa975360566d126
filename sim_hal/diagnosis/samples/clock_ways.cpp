#include "clock_ways.h"

#include <algorithm>
#include <cmath>

#include "../replay/robot_reference.h"

namespace berth
{

namespace
{

double begin_of(const record &data)
{
    return data.time_s.front() - data.time_origin_s;
}

} // namespace

std::vector<double> slip_times_s(const rig &rig, const record &data)
{
    constexpr std::size_t many = 1000;
    const double period_ms = 1e3 * data.period_s;
    const double drift_ms_per_s = 1e-3 * rig.robot.clock_drift_ppm;
    const double phase_ms = rig.robot.clock_phase_ms - 1e3 * setpoint_arrival_s(rig);
    const auto periods_late = [&](double time_s) { return (phase_ms + drift_ms_per_s * time_s) / period_ms; };
    const double at_begin = periods_late(begin_of(data));
    const double at_end = periods_late(data.time_s.back() - data.time_origin_s);
    const double last = std::max(at_begin, at_end);
    std::vector<double> times_s;
    double whole = std::ceil(std::min(at_begin, at_end));
    while (whole < last && times_s.size() < many) {
        times_s.push_back((whole * period_ms - phase_ms) / drift_ms_per_s);
        whole++;
    }
    return times_s;
}

clock_ways::clock_ways(const fit_result &fitted, const record &data)
{
    const std::vector<double> slips_s = slip_times_s(fitted.rig, data);
    has_slips = !slips_s.empty();
    for (const double time_s : slips_s) {
        pivot_s += time_s / static_cast<double>(slips_s.size());
    }
    const auto dead_time = std::find_if(fitted.parameters.begin(), fitted.parameters.end(),
                                        [](const auto &one) { return one.key->path == "robot.dead_time_ms"; });
    if (dead_time != fitted.parameters.end()) {
        least_ms_ = dead_time->low;
        most_ms_ = dead_time->high;
    }
    middle_s_ = begin_of(data) + 0.5 * data.period_s * static_cast<double>(data.size());
}

void clock_ways::turn_about(rig &rig, double by_ppm, double time_s) const
{
    rig.robot.clock_drift_ppm += by_ppm;
    rig.robot.clock_phase_ms -= 1e-3 * by_ppm * time_s;
    make_up(rig, 1e-3 * by_ppm * (middle_s_ - time_s));
}

void clock_ways::shift(rig &rig, double by_ms) const
{
    rig.robot.clock_phase_ms += by_ms;
    make_up(rig, by_ms);
}

void clock_ways::make_up(rig &rig, double late_ms) const
{
    if (most_ms_ > least_ms_) {
        rig.robot.dead_time_ms = std::min(std::max(rig.robot.dead_time_ms - late_ms, least_ms_), most_ms_);
    }
}

} // namespace berth
