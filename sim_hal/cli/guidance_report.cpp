#include "guidance_report.h"

#include <cstdio>
#include <string>

namespace berth
{

void guidance_report::note_tick(std::int64_t tick, const arm_record &record)
{
    for (std::size_t i = 0; i < limits_.size(); i++) {
        if (((record.guided_by >> i) & 1) != 0) {
            limits_[i].first_tick = limits_[i].ticks == 0 ? tick : limits_[i].first_tick;
            limits_[i].ticks++;
        }
    }
}

void guidance_report::print(double period_s) const
{
    std::string acted;
    std::uint32_t limit = 0;
    for (std::size_t i = 0; i < limits_.size(); i++) {
        if (limits_[i].ticks > 0) {
            char text[96];
            std::snprintf(text, sizeof text, "%s%s in %u ticks, first at %.2f s", acted.empty() ? "" : "; ",
                          guidance_limit_names[i], limits_[i].ticks,
                          period_s * static_cast<double>(limits_[i].first_tick));
            acted += text;
            limit |= 1U << i;
        }
    }
    std::printf("  %-14s %s%s%s\n", "guidance", acted.empty() ? "never acted" : "acted: ", acted.c_str(),
                (limit & GUIDANCE_SINGULAR) != 0
                    ? ": near a singular pose the tool falls behind its order, and may stop short of it"
                    : "");
}

nlohmann::json guidance_report::as_json(double period_s) const
{
    nlohmann::json ticks;
    nlohmann::json first_s;
    for (std::size_t i = 0; i < limits_.size(); i++) {
        ticks[guidance_limit_names[i]] = limits_[i].ticks;
        first_s[guidance_limit_names[i]] =
            limits_[i].ticks > 0 ? nlohmann::json(period_s * static_cast<double>(limits_[i].first_tick))
                                 : nlohmann::json();
    }
    return {{"ticks", ticks}, {"first_s", first_s}};
}

} // namespace berth
