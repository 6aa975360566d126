#include "wheel_report.h"

#include <cmath>
#include <cstdio>
#include <string>

namespace berth
{

void wheel_report::note_tick(std::int64_t tick, const arm_record &record, const attitude_config &config)
{
    constexpr double rounding = 1e-9; /* of a momentum that the law fills to its limit */
    if (config.actuator != ATTITUDE_WHEEL) {
        return;
    }
    const double held_N_m_s[] = {record.wheel_x_N_m_s, record.wheel_y_N_m_s, record.wheel_z_N_m_s};
    bool is_full = false;
    for (std::size_t axis = 0; axis < axis_ticks_.size(); axis++) {
        if (std::abs(held_N_m_s[axis]) >= (1.0 - rounding) * config.momentum_limit_N_m_s) {
            axis_ticks_[axis]++;
            is_full = true;
        }
    }
    first_tick_ = is_full && ticks_ == 0 ? tick : first_tick_;
    ticks_ += is_full;
}

void wheel_report::print(double period_s, const attitude_config &config) const
{
    if (config.actuator != ATTITUDE_WHEEL) {
        return;
    }
    if (!any()) {
        std::printf("  %-14s %s\n", "wheel", "never full");
        return;
    }
    std::string axes;
    for (std::size_t axis = 0; axis < axis_ticks_.size(); axis++) {
        if (axis_ticks_[axis] > 0) {
            axes += (axes.empty() ? "" : ", ") + std::string(1, "xyz"[axis]) + " in " +
                    std::to_string(axis_ticks_[axis]);
        }
    }
    std::printf("  %-14s full (%g N m s) in %u ticks, first at %.2f s (%s): it held the satellite's attitude no "
                "longer\n",
                "wheel", config.momentum_limit_N_m_s, ticks_, period_s * static_cast<double>(first_tick_),
                axes.c_str());
}

nlohmann::json wheel_report::as_json(double period_s, const attitude_config &config) const
{
    if (config.actuator != ATTITUDE_WHEEL) {
        return nullptr;
    }
    return {{"full_ticks", ticks_},
            {"first_s", any() ? nlohmann::json(period_s * static_cast<double>(first_tick_)) : nlohmann::json()},
            {"axis_full_ticks", axis_ticks_}};
}

} // namespace berth
