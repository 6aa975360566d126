#include "parameter_report.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "../stability/stable_intervals.h"
#include "gains_report.h"
#include "json_or_null.h"
#include "short_number.h"

namespace berth
{

namespace
{

nlohmann::json limit_json(const stability_limit *limit)
{
    if (limit == nullptr) {
        return nullptr;
    }
    return {{"value", limit->value},
            {"stable", limit->stable_above ? "above" : "below"},
            {"jump", !limit->jump.empty()},
            {"rough", limit->is_rough},
            {"jump_reason", limit->jump.empty() ? nlohmann::json() : nlohmann::json(limit->jump)},
            {"mode", limit->mode_name},
            {"frequency_Hz", limit->mode.frequency_Hz}};
}

std::string number_or_dash(const std::optional<double> &value)
{
    return value ? short_number(*value) : "-";
}

std::string value_of(const stability_limit *limit)
{
    return limit != nullptr ? short_number(limit->value) : "none";
}

void print_line(const char *key, const std::string &own, const std::string &below, const std::string &above,
                const std::string &first_order_below, const std::string &first_order_above)
{
    std::printf("  %-32s %12s %12s %12s   %12s %12s\n", key, own.c_str(), below.c_str(), above.c_str(),
                first_order_below.c_str(), first_order_above.c_str());
}

void print_mode(const stability_limit *limit, bool is_below)
{
    if (limit != nullptr) {
        const std::string what = limit->stable_above == is_below ? "lost" : "regained";
        std::printf("  %32s   %.4f Hz, %s%s%s\n", (what + (is_below ? " below" : " above")).c_str(),
                    limit->mode.frequency_Hz, limit->mode_name.c_str(),
                    limit->jump.empty() ? "" : "; jumps: ", limit->jump.c_str());
    }
}

void print_intervals(const parameter_limits &parameter)
{
    if (parameter.limits.size() < 2) {
        return;
    }
    std::printf("  %32s  ", "stable in");
    for (const stable_interval &interval : parameter.stable) {
        const bool is_open = is_open_beyond(parameter) && interval.to == parameter.to;
        std::printf(
            " %s",
            is_open ? ("[" + short_number(interval.from) + ", at least " + short_number(interval.to) + "]").c_str()
                    : interval_text(interval).c_str());
    }
    std::printf("\n");
}

} // namespace

std::string interval_text(const stable_interval &interval)
{
    const std::string from = short_number(interval.from);
    const std::string to = short_number(interval.to);
    return from == to ? from + " alone" : "[" + from + ", " + to + "]";
}

nlohmann::json intervals_json(const std::vector<stable_interval> &intervals)
{
    nlohmann::json list = nlohmann::json::array();
    for (const stable_interval &interval : intervals) {
        list.push_back({interval.from, interval.to});
    }
    return list;
}

nlohmann::json parameter_json(const parameter_limits &parameter)
{
    nlohmann::json limits = nlohmann::json::array();
    for (const stability_limit &limit : parameter.limits) {
        limits.push_back(limit_json(&limit));
    }
    return {{"value", parameter.value},
            {"range", {parameter.from, parameter.to}},
            {"below", limit_json(parameter.nearest_below())},
            {"above", limit_json(parameter.nearest_above())},
            {"limits", limits},
            {"stable_intervals", intervals_json(parameter.stable)},
            {"first_order_below", or_null(parameter.first_order_below())},
            {"first_order_above", or_null(parameter.first_order_above())}};
}

nlohmann::json rates_json(const std::vector<rate_verdict> &rates)
{
    nlohmann::json list = nlohmann::json::array();
    for (const rate_verdict &rate : rates) {
        if (rate.refusal.empty()) {
            list.push_back({{"rate_Hz", rate.rate_Hz}, {"stable", rate.is_stable}});
        } else {
            list.push_back({{"rate_Hz", rate.rate_Hz}, {"stable", nullptr}, {"refusal", rate.refusal}});
        }
    }
    return list;
}

void print_parameters(const std::vector<parameter_limits> &parameters, const scan &how)
{
    std::printf("  %-32s %12s %25s   %25s\n", "", "", "nearest limit", "first-order formula");
    print_line("parameter", "value", "below", "above", "below", "above");
    for (const parameter_limits &parameter : parameters) {
        print_line(std::string(parameter.key).c_str(), short_number(parameter.value),
                   value_of(parameter.nearest_below()), value_of(parameter.nearest_above()),
                   number_or_dash(parameter.first_order_below()), number_or_dash(parameter.first_order_above()));
        print_mode(parameter.nearest_below(), true);
        print_mode(parameter.nearest_above(), false);
        print_intervals(parameter);
    }
    std::printf(
        "none: no limit within a factor of %g either way (delays: 10), as far as a rig may go; ends of that range\n"
        "end intervals, too. Intervals narrower than %.3g %% may be overlooked.\n",
        how.factor, 100.0 * how.step);
}

void print_rates(const char *which, const std::vector<rate_verdict> &rates)
{
    std::printf("%s\n", which);
    const auto print_those = [&](const char *title, const auto &belongs) {
        std::string those;
        for (const rate_verdict &rate : rates) {
            if (belongs(rate)) {
                those += " " + short_number(rate.rate_Hz);
            }
        }
        std::printf("  %-14s%s\n", title, those.empty() ? " none" : those.c_str());
    };
    print_those("stable", [](const rate_verdict &r) { return r.is_stable; });
    print_those("unstable", [](const rate_verdict &r) { return r.refusal.empty() && !r.is_stable; });
    print_those("not possible", [](const rate_verdict &r) { return !r.refusal.empty(); });
    for (std::size_t i = 0; i < rates.size(); i++) {
        const std::string &refusal = rates[i].refusal;
        const std::string key = refusal.substr(0, refusal.find(':'));
        if (!refusal.empty() && (i == 0 || rates[i - 1].refusal.compare(0, key.size(), key) != 0)) {
            std::printf("  %-14s %g: %s\n", "", rates[i].rate_Hz, refusal.c_str());
        }
    }
}

} // namespace berth
