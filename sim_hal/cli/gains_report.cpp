#include "gains_report.h"

#include <cmath>
#include <cstdio>
#include <string>

#include "../advice.h"
#include "json_or_null.h"

namespace berth
{

namespace
{

nlohmann::json as_json(const std::optional<changed_loop> &changed, const loop_quality &now)
{
    if (!changed) {
        return nullptr;
    }
    const loop_quality &quality = changed->quality;
    return {{"value", changed->value},
            {"growth_per_s", quality.mode.growth_per_s},
            {"modulus", or_null(quality.margin)},
            {"frequency_Hz", quality.mode.frequency_Hz},
            {"mode", quality.mode_name},
            {"force_older_by_ticks", quality.force_age_ticks - now.force_age_ticks}};
}

/* The rate stands there twice. */
std::string name_of(const parameter_gain &gain)
{
    const bool is_rate = gain.key == "loop.rate_Hz";
    return std::string(gain.key) + (!is_rate                            ? ""
                                    : gain.delays == delays_stay::in_ms ? ", delays in ms"
                                                                        : ", in ticks");
}

nlohmann::json as_json(const parameter_gain &gain, const changed_loop *better, const loop_quality &now)
{
    nlohmann::json json = {{"key", gain.key},
                           {"value", gain.value},
                           {"to", nullptr},
                           {"gain_per_s", nullptr},
                           {"less", as_json(gain.less, now)},
                           {"more", as_json(gain.more, now)}};
    if (gain.key == "loop.rate_Hz") {
        json["delays_stay"] = gain.delays == delays_stay::in_ms ? "in ms" : "in ticks";
    }
    if (better != nullptr) {
        json["to"] = better->value;
        json["gain_per_s"] = now.mode.growth_per_s - better->quality.mode.growth_per_s;
    }
    return json;
}

std::string ticks_text(int older)
{
    if (older == 0) {
        return "";
    }
    return "; the force becomes " + std::to_string(std::abs(older)) + (std::abs(older) == 1 ? " tick " : " ticks ") +
           (older > 0 ? "older" : "younger");
}

std::string margin_text(const std::optional<double> &margin)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.4f", margin.value_or(0.0));
    return margin ? text : "-";
}

void print_rank(const std::vector<parameter_gain> &gains, const loop_quality &now,
                const changed_loop *(parameter_gain::*better_of)() const)
{
    std::printf("  %-32s %12s %12s %12s %12s %8s  %s\n", "parameter", "from", "to", "gain /s", "growth /s", "margin",
                "what decides then");
    for (const parameter_gain &gain : gains) {
        const changed_loop *const better = (gain.*better_of)();
        if (better == nullptr) {
            std::printf("  %-32s %12.6g %12s\n", name_of(gain).c_str(), gain.value, "fixed");
            continue;
        }
        const loop_quality &then = better->quality;
        std::printf("  %-32s %12.6g %12.6g %+12.6f %+12.6f %8s  %.4g Hz, %s%s\n", name_of(gain).c_str(), gain.value,
                    better->value, now.mode.growth_per_s - then.mode.growth_per_s, then.mode.growth_per_s,
                    margin_text(then.margin).c_str(), then.mode.frequency_Hz, then.mode_name.c_str(),
                    ticks_text(then.force_age_ticks - now.force_age_ticks).c_str());
    }
}

} // namespace

nlohmann::json as_json(const gain_ranking &ranking)
{
    nlohmann::json json = {{"change", ranking.share}, {"rank", nlohmann::json::array()}};
    if (!ranking.now) {
        return json;
    }
    const loop_quality &now = *ranking.now;
    json["modulus"] = or_null(now.margin);
    std::vector<parameter_gain> gains = ranking.gains;
    rank_by_decay(gains);
    for (const parameter_gain &gain : gains) {
        json["rank"].push_back(as_json(gain, gain.decaying_faster(), now));
    }
    json["rank_by_modulus"] = nlohmann::json::array();
    rank_by_margin(gains);
    for (const parameter_gain &gain : gains) {
        json["rank_by_modulus"].push_back(as_json(gain, gain.with_more_margin(), now));
    }
    return json;
}

void print_gains(const gain_ranking &ranking)
{
    if (!ranking.now) {
        return;
    }
    const loop_quality &now = *ranking.now;
    std::vector<parameter_gain> gains = ranking.gains;
    std::printf("what helps most: one thing changed by %g %%, the way after which motion decays faster\n",
                100.0 * ranking.share);
    rank_by_decay(gains);
    print_rank(gains, now, &parameter_gain::decaying_faster);
    if (now.margin) {
        std::printf(
            "what gives the most margin (now %.4f; smallest |1 + L|: 0 is about to swing): the way after which "
            "it is larger\n",
            *now.margin);
        rank_by_margin(gains);
        print_rank(gains, now, &parameter_gain::with_more_margin);
    }
}

nlohmann::json nearest_limit_json(const std::vector<parameter_limits> &parameters, bool is_stable)
{
    const std::optional<near_limit> nearest = nearest_limit(parameters, is_stable);
    if (!nearest) {
        return nullptr;
    }
    return {{"key", nearest->key},
            {"value", nearest->limit.value},
            {"factor", nearest->value > 0.0 ? nlohmann::json(nearest->factor()) : nlohmann::json()},
            {"rough", nearest->limit.is_rough},
            {"jump", !nearest->limit.jump.empty()}};
}

void print_nearest_limit(const std::vector<parameter_limits> &parameters, bool is_stable)
{
    const std::optional<near_limit> nearest = nearest_limit(parameters, is_stable);
    if (nearest) {
        char share[40] = "";
        if (nearest->value > 0.0) {
            std::snprintf(share, sizeof share, " (%+.3g %%)", 100.0 * (nearest->factor() - 1.0));
        }
        std::printf("  the smallest change that %s: %s from %.9g to %.9g%s%s\n",
                    is_stable ? "ends stability" : "makes it stable", nearest->key.c_str(), nearest->value,
                    nearest->limit.value, share,
                    nearest->limit.jump.empty() ? "" : (": " + nearest->limit.jump).c_str());
    }
}

} // namespace berth
