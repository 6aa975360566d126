#include "bounce_report.h"

#include <cmath>
#include <cstdio>

#include "../../firmware/arm/arm_config.h"

namespace berth
{

bounce_answer answer_bounce(const rig &rig, const std::vector<std::string_view> &keys)
{
    bounce_answer answer;
    if (rig.object.kind != object_kind::contact || rig.firmware.arm.kind != ARM_NONE) {
        return answer;
    }
    answer.own = play_bounce(rig);
    for (const std::string_view key : keys) {
        answer.limits.emplace_back(key, answer.own ? find_bounce_limit(rig, key) : std::nullopt);
    }
    return answer;
}

void print_bounce(const bounce_answer &answer)
{
    if (!answer.own) {
        return;
    }
    const played_bounce &own = *answer.own;
    std::printf("  %-14s restitution %.4f at %.2g m/s, in contact for %.3g s: %s %.3g %% of its energy\n", "bounce",
                own.restitution, own.speed_in_m_per_s, own.contact_s,
                own.energy_share() > 0.0 ? "each gains" : "each loses", 100.0 * std::abs(own.energy_share()));
    for (const auto &[key, limit] : answer.limits) {
        const std::string name(key);
        if (limit) {
            std::printf("  %-14s a bounce gains energy with %s %s %.4g\n", "", name.c_str(),
                        limit->gains_above ? "above" : "below", limit->value);
        } else {
            std::printf("  %-14s %s: no value near it changes that\n", "", name.c_str());
        }
    }
}

nlohmann::json bounce_json(const bounce_answer &answer)
{
    if (!answer.own) {
        return nullptr;
    }
    nlohmann::json json = {{"restitution", answer.own->restitution},
                           {"speed_m_per_s", answer.own->speed_in_m_per_s},
                           {"energy_share", answer.own->energy_share()},
                           {"contact_s", answer.own->contact_s},
                           {"limits", nlohmann::json::object()}};
    for (const auto &[key, limit] : answer.limits) {
        json["limits"][std::string(key)] =
            limit ? nlohmann::json{{"value", limit->value}, {"gains", limit->gains_above ? "above" : "below"}}
                  : nlohmann::json();
    }
    return json;
}

} // namespace berth
