#include "motor_report.h"

#include <cstdio>
#include <string>

namespace berth
{

void motor_report::note_tick(std::int64_t tick, const arm_record &record)
{
    if (record.motors_at_limit == 0) {
        return;
    }
    first_tick_ = ticks_ == 0 ? tick : first_tick_;
    ticks_++;
    for (std::size_t i = 0; i < joint_ticks_.size(); i++) {
        joint_ticks_[i] += (record.motors_at_limit >> i) & 1;
    }
}

void motor_report::print(double period_s) const
{
    if (!is_told || !any()) {
        std::printf("  %-14s %s\n", "motors",
                    is_told ? "never at their torque limit" : "the log does not tell whether at their torque limit");
        return;
    }
    std::string joints;
    for (std::size_t i = 0; i < joint_ticks_.size(); i++) {
        if (joint_ticks_[i] > 0) {
            joints += (joints.empty() ? "joint " : ", joint ") + std::to_string(i + 1) + " in " +
                      std::to_string(joint_ticks_[i]);
        }
    }
    std::printf("  %-14s at their torque limit in %u ticks, first at %.2f s (%s)\n", "motors", ticks_,
                period_s * static_cast<double>(first_tick_), joints.c_str());
}

nlohmann::json motor_report::as_json(double period_s, std::int64_t joint_count) const
{
    if (!is_told) {
        return nullptr;
    }
    return {
        {"limit_ticks", ticks_},
        {"first_s", any() ? nlohmann::json(period_s * static_cast<double>(first_tick_)) : nlohmann::json()},
        {"joint_limit_ticks", std::vector<std::uint32_t>(joint_ticks_.begin(), joint_ticks_.begin() + joint_count)}};
}

} // namespace berth
