#include "reduce_amplitude.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "../../hal/rig/rig_file.h"

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
    return names;
}

nlohmann::json swing_json(const swing &swing)
{
    return {{"frequency_Hz", swing.frequency_Hz}, {"damping_ratio", swing.damping_ratio}};
}

nlohmann::json as_json(const amplitude_result::limits &limits)
{
    const auto number = [](const std::optional<double> &value) {
        return value ? nlohmann::json(*value) : nlohmann::json();
    };
    return {{"frequency_m", number(limits.frequency_m)}, {"damping_m", number(limits.damping_m)}};
}

std::string limit_text(const std::optional<double> &from_m, const amplitude_range &range)
{
    char text[64];
    if (!from_m) {
        return "nowhere";
    }
    std::snprintf(text, sizeof text, *from_m > range.from_m ? "from %.4g m on" : "all the way from %.4g m on",
                  *from_m);
    return text;
}

} // namespace

amplitude_range amplitudes_of(const std::string &text)
{
    amplitude_range range = {};
    const char *at = text.c_str();
    char *end = nullptr;
    range.from_m = std::strtod(at, &end);
    bool is_fine = end != at && *end == ':';
    at = end + (is_fine ? 1 : 0);
    range.to_m = std::strtod(at, &end);
    is_fine = is_fine && end != at && *end == ':';
    at = end + (is_fine ? 1 : 0);
    const long count = std::strtol(at, &end, 10);
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

amplitude_result look_at_amplitudes(const arm_config &config, const reduction_choice &choice,
                                    const object_rig &object, const reduction &found, const amplitude_range &range)
{
    const std::vector<beam_mode> modes = object_modes(object);
    const std::optional<coupled_mode> mode = nearest_mode(config, choice, modes, found.coupled_reduced.frequency_Hz);
    if (!mode || !(found.coupled_reduced.frequency_Hz > 0.0)) {
        throw input_error("--amplitude: with the object the arm does not swing at this pose");
    }
    const auto measured = [&](double amplitude_m) { return swing_from(config, choice, modes, *mode, amplitude_m); };
    amplitude_result result;
    result.small = found.coupled_full;
    result.reduced = found.coupled_reduced;
    for (int i = 0; i < range.count; i++) {
        const double share = static_cast<double>(i) / (range.count - 1);
        const double amplitude_m = std::pow(range.from_m, 1.0 - share) * std::pow(range.to_m, share);
        result.rows.push_back({amplitude_m, measured(amplitude_m)});
    }
    const auto first_beyond = [&](double swing::*value, const swing &known) -> std::optional<double> {
        const auto is_beyond = [&](const free_swing &full) {
            return std::fabs(off(known.*value, full.found.*value)) > exceeded;
        };
        for (std::size_t i = 0; i < result.rows.size() && result.rows[i].full; i++) {
            if (!is_beyond(*result.rows[i].full)) {
                continue;
            }
            double beyond_m = result.rows[i].amplitude_m;
            double within_m = i > 0 ? result.rows[i - 1].amplitude_m : beyond_m;
            while (beyond_m > within_m * (1.0 + fine)) {
                const double middle_m = std::sqrt(within_m * beyond_m);
                const std::optional<free_swing> middle = measured(middle_m);
                (!middle || is_beyond(*middle) ? beyond_m : within_m) = middle_m;
            }
            return beyond_m;
        }
        return {};
    };
    const auto both = [&](const swing &known) {
        return amplitude_result::limits{first_beyond(&swing::frequency_Hz, known),
                                        first_beyond(&swing::damping_ratio, known)};
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
    const auto row = [&](const char *amplitude, const swing &full, const std::string &more) {
        std::printf("    %12s %10.4f %9.2f%% %10.5f %9.2f%%%s\n", amplitude, full.frequency_Hz,
                    100.0 * off(reduced.frequency_Hz, full.frequency_Hz), full.damping_ratio,
                    100.0 * off(reduced.damping_ratio, full.damping_ratio), more.c_str());
    };
    row("small", result.small, "");
    for (const amplitude_row &at : result.rows) {
        char amplitude[32];
        std::snprintf(amplitude, sizeof amplitude, "%.4g", at.amplitude_m);
        if (!at.full) {
            std::printf("    %12s  does not swing so far\n", amplitude);
            continue;
        }
        std::string more;
        for (const std::string &name : names_of(at.full->limits)) {
            more.append(more.empty() ? "   at its limit: " : ", ").append(name);
        }
        row(amplitude, at.full->found, more);
    }
    const amplitude_range range = {result.rows.front().amplitude_m, result.rows.back().amplitude_m,
                                   static_cast<int>(result.rows.size())};
    const auto line = [&](const char *what, const amplitude_result::limits &limits) {
        std::printf("  %s: frequency %s, damping ratio %s\n", what, limit_text(limits.frequency_m, range).c_str(),
                    limit_text(limits.damping_m, range).c_str());
    };
    line("the reduction is off by more than 1 %", result.reduced_off);
    line("by its size alone the swing of the whole arm changes by 1 %", result.size_alone);
}

nlohmann::json as_json(const amplitude_result &result)
{
    nlohmann::json rows = nlohmann::json::array();
    for (const amplitude_row &at : result.rows) {
        nlohmann::json row = {{"amplitude_m", at.amplitude_m}, {"full", nullptr}, {"at_limit", nullptr}};
        if (at.full) {
            row["full"] = swing_json(at.full->found);
            row["at_limit"] = names_of(at.full->limits);
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
