#include "reduce_amplitude.h"

#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>

#include "../../hal/rig/rig_file.h"
#include "../effects/active.h"
#include "json_or_null.h"
#include "number.h"
#include "progress_line.h"

namespace berth
{

namespace
{

constexpr double exceeded = 0.01;
constexpr double fine = 1e-3; /* ratio to which the amplitude where it is exceeded is found */

double off(double value, double truth)
{
    return value / truth - 1.0;
}

std::string joint_name(int joint)
{
    return "joint " + std::to_string(joint + 1);
}

std::vector<std::string> names_of(const limits_met &limits)
{
    std::vector<std::string> names;
    for (int i = 0; i < ARM_JOINTS_MAX; i++) {
        if (limits.joints[i]) {
            names.push_back(joint_name(i));
        }
    }
    if (limits.wheel) {
        names.emplace_back("wheel");
    }
    if (limits.wheel_momentum) {
        names.emplace_back("wheel's momentum");
    }
    return names;
}

nlohmann::json swing_json(const swing &swing)
{
    return {{"frequency_Hz", swing.frequency_Hz}, {"damping_ratio", swing.damping_ratio}};
}

nlohmann::json as_json(const amplitude_result::limits &limits)
{
    return {{"frequency_m", or_null(limits.frequency.from_m)},
            {"frequency_determined", limits.frequency.is_determined},
            {"damping_m", or_null(limits.damping.from_m)},
            {"damping_determined", limits.damping.is_determined}};
}

std::string limit_text(const amplitude_result::limit &limit, double first_m)
{
    char text[64];
    if (limit.from_m) {
        std::snprintf(text, sizeof text, *limit.from_m > first_m ? "from %.4g m on" : "all the way from %.4g m on",
                      *limit.from_m);
        return text;
    }
    if (limit.is_determined) {
        return "nowhere";
    }
    if (!(limit.looked_to_m > 0.0)) {
        return "not determined";
    }
    std::snprintf(text, sizeof text, "not up to %.4g m, beyond it not determined", limit.looked_to_m);
    return text;
}

using measured_swing = std::function<free_swing(double amplitude_m)>;

/* `value` of the whole arm against a `known` one. */
amplitude_result::limit first_beyond(const std::vector<amplitude_row> &rows, const measured_swing &measured,
                                     std::optional<double> free_swing::*value, double known)
{
    amplitude_result::limit limit;
    const auto is_beyond = [&](const free_swing &full) { return std::fabs(off(known, *(full.*value))) > exceeded; };
    for (const amplitude_row &row : rows) {
        if (!(row.full.*value)) {
            return limit;
        }
        if (!is_beyond(row.full)) {
            limit.looked_to_m = row.amplitude_m;
            continue;
        }
        double beyond_m = row.amplitude_m;
        while (limit.looked_to_m > 0.0 && beyond_m > limit.looked_to_m * (1.0 + fine)) {
            const double middle_m = std::sqrt(limit.looked_to_m * beyond_m);
            const free_swing middle = measured(middle_m);
            if (!(middle.*value)) {
                return limit;
            }
            (is_beyond(middle) ? beyond_m : limit.looked_to_m) = middle_m;
        }
        limit.from_m = beyond_m;
        break;
    }
    limit.is_determined = true;
    return limit;
}

} // namespace

amplitude_range amplitudes_of(const std::string &text)
{
    amplitude_range range = {};
    const char *at = text.c_str();
    const char *end = nullptr;
    range.from_m = number_at<double>(at, &end);
    bool is_fine = end != at && *end == ':';
    at = end + (is_fine ? 1 : 0);
    range.to_m = number_at<double>(at, &end);
    is_fine = is_fine && end != at && *end == ':';
    at = end + (is_fine ? 1 : 0);
    const long count = number_at<long>(at, &end);
    is_fine = is_fine && end != at && *end == '\0' && count >= 2 && count <= 1000;
    if (!is_fine || !(range.from_m >= 1e-6 && range.to_m > range.from_m && range.to_m <= 1e3)) {
        throw input_error(
            "--amplitude " + text +
            ": must be FROM:TO:COUNT, of the tool's deflection in m, rising within 1e-6 to 1e3, with a "
            "count from 2 to 1000");
    }
    range.count = static_cast<int>(count);
    return range;
}

amplitude_result look_at_amplitudes(const arm_config &config, const reduction_choice &choice, const rig &rig,
                                    const reduction &found, const amplitude_range &range)
{
    const std::string effects = effect_keys_of(rig, is_beyond_free_swing);
    if (!effects.empty()) {
        throw input_error("--amplitude: lets the arm go with the object alone, without the rig's " + effects +
                          "; set to 0 what the swing is to be without");
    }
    const std::vector<beam_mode> modes = object_modes(rig.object);
    if (!found.nearest) {
        throw input_error("--amplitude: " + none_is_near(found.visible, found.coupled_reduced.frequency_Hz) +
                          "; take another pose or direction");
    }
    const auto measured = [&](double amplitude_m) {
        return swing_from(config, choice, modes, *found.nearest, amplitude_m);
    };
    amplitude_result result;
    result.small = *found.coupled_full;
    result.reduced = found.coupled_reduced;
    const progress_line progress;
    for (int i = 0; i < range.count; i++) {
        progress.show("reduce: amplitude " + std::to_string(i + 1) + " of " + std::to_string(range.count));
        const double share = static_cast<double>(i) / (range.count - 1);
        const double amplitude_m = std::pow(range.from_m, 1.0 - share) * std::pow(range.to_m, share);
        result.rows.push_back({amplitude_m, measured(amplitude_m)});
    }
    const auto both = [&](const swing &known) {
        return amplitude_result::limits{
            first_beyond(result.rows, measured, &free_swing::frequency_Hz, known.frequency_Hz),
            first_beyond(result.rows, measured, &free_swing::damping_ratio, known.damping_ratio)};
    };
    result.reduced_off = both(result.reduced);
    result.size_alone = both(result.small);
    return result;
}

void print_amplitudes(const amplitude_result &result)
{
    const swing &reduced = result.reduced;
    std::printf("  with the object, no dead time, let go of from a deflection: the whole arm, and by how much its "
                "reduction is off\n"
                "    %12s %10s %10s %10s %10s\n",
                "amplitude m", "Hz", "off", "damping", "off");
    const auto row = [&](const char *amplitude, double frequency_Hz, const std::optional<double> &damping_ratio,
                         const std::string &more) {
        std::printf("    %12s %10.4f %9.2f%% ", amplitude, frequency_Hz,
                    100.0 * off(reduced.frequency_Hz, frequency_Hz));
        if (damping_ratio) {
            std::printf("%10.5f %9.2f%%", *damping_ratio, 100.0 * off(reduced.damping_ratio, *damping_ratio));
        }
        std::printf("%s\n", more.c_str());
    };
    row("small", result.small.frequency_Hz, result.small.damping_ratio, "");
    for (const amplitude_row &at : result.rows) {
        char amplitude[32];
        std::snprintf(amplitude, sizeof amplitude, "%.4g", at.amplitude_m);
        if (!at.full.frequency_Hz) {
            std::printf("    %12s  %s\n", amplitude, at.full.not_measured.c_str());
            continue;
        }
        std::string more = at.full.not_measured;
        bool is_first = true;
        for (const std::string &name : names_of(at.full.limits)) {
            more.append(is_first ? "   at its limit: " : ", ").append(name);
            is_first = false;
        }
        row(amplitude, *at.full.frequency_Hz, at.full.damping_ratio, more);
    }
    const auto line = [&](const char *what, const amplitude_result::limits &limits) {
        const double first_m = result.rows.front().amplitude_m;
        std::printf("  %s: frequency %s, damping ratio %s\n", what, limit_text(limits.frequency, first_m).c_str(),
                    limit_text(limits.damping, first_m).c_str());
    };
    line("the reduction's error is above 1 %", result.reduced_off);
    line("by its size alone the swing of the whole arm changes by 1 %", result.size_alone);
}

nlohmann::json as_json(const amplitude_result &result)
{
    nlohmann::json rows = nlohmann::json::array();
    for (const amplitude_row &at : result.rows) {
        nlohmann::json row = {
            {"amplitude_m", at.amplitude_m}, {"full", nullptr}, {"not_measured", nullptr}, {"at_limit", nullptr}};
        if (at.full.frequency_Hz) {
            row["full"] = {{"frequency_Hz", *at.full.frequency_Hz},
                           {"damping_ratio", or_null(at.full.damping_ratio)}};
            row["at_limit"] = names_of(at.full.limits);
        }
        if (!at.full.not_measured.empty()) {
            row["not_measured"] = at.full.not_measured;
        }
        rows.push_back(row);
    }
    return {{"small", swing_json(result.small)},
            {"reduced", swing_json(result.reduced)},
            {"rows", rows},
            {"reduced_off_1_percent", as_json(result.reduced_off)},
            {"size_alone_1_percent", as_json(result.size_alone)}};
}

} // namespace berth
