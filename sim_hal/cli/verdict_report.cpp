#include "verdict_report.h"

#include <cstdio>

#include "../../hal/rig/toml_file.h"
#include "../plausibility.h"
#include "../verdict_words.h"
#include "colour.h"
#include "gains_report.h"
#include "json_or_null.h"
#include "short_number.h"

namespace berth
{

namespace
{

constexpr const char *line_format = "  %-14s %s\n";

std::string_view section_of(std::string_view key)
{
    return key.substr(0, key.find('.'));
}

nlohmann::json peak_json(const force_peak &peak)
{
    return {{"force_N", peak.force_N}, {"at_s", peak.at_s}};
}

/* What the verdict says of growth; null where it says nothing, as of a rate smaller than its interval. */
nlohmann::json growth_json(const std::optional<growth_finding> &growth)
{
    if (!growth) {
        return nullptr;
    }
    return {{"origin", growth_origin_name(growth->origin)},
            {"growth_per_s", growth->growth_per_s},
            {"growth_ci95_per_s", growth->ci95_per_s}};
}

ink ink_of(const stability_verdict &verdict)
{
    return !verdict.is_stable ? ink::yellow : *verdict.is_stable ? ink::green : ink::red;
}

} // namespace

std::string stability_word(bool is_stable)
{
    return is_stable ? coloured(stdout, ink::green, "stable") : coloured(stdout, ink::red, "unstable");
}

void add_caveat_of_run(stability_verdict &verdict, const rig &rig)
{
    if (never_grips(rig)) {
        verdict.caveat = "of the loop once it is closed: the run of this rig never grips the object; let "
                         "run.grip_close_s lie within the run";
    }
}

void print_caveat(const stability_verdict &verdict)
{
    if (!verdict.caveat.empty()) {
        std::printf(line_format, "caveat", verdict.caveat.c_str());
    }
}

void print_verdict(const stability_verdict &verdict)
{
    const std::string name = verdict_name(verdict.kind);
    const std::string padding(name.size() < 14 ? 14 - name.size() : 0, ' ');
    std::printf("  %s%s %s\n", coloured(stdout, ink_of(verdict), name).c_str(), padding.c_str(),
                verdict.because.c_str());
    print_caveat(verdict);
    if (!verdict.advice.empty()) {
        std::printf(line_format, "advice", verdict.advice.c_str());
    }
}

void print_assumptions(const rig &rig)
{
    const std::vector<assumption> all = assumptions_of(rig);
    const char *title = "assumed";
    for (auto first = all.begin(); first != all.end();) {
        const std::string_view section = section_of(first->key);
        std::string line = "[" + std::string(section) + "]";
        for (; first != all.end() && section_of(first->key) == section; ++first) {
            line += (line.back() == ']' ? " " : ", ") + std::string(first->key.substr(section.size() + 1)) + " = " +
                    first->value;
        }
        std::printf(line_format, title, line.c_str());
        title = "";
    }
}

/* "; 102.4 ms from 5 s on", of what a schedule makes of the delay in the end; empty: it stays. */
std::string scheduled_delay_words(const rig &rig)
{
    const std::vector<scheduled_delay> later = delays_of_schedule(rig);
    if (later.empty()) {
        return "";
    }
    const scheduled_delay &last = later.back();
    return with_numbers(later.size() == 1 ? "; %.4g ms from %.3g s on" : "; it changes to %.4g ms at %.3g s",
                        last.total_ms, last.from_s);
}

void print_delay_budget(const rig &rig)
{
    if (touches_nothing(rig)) {
        return; /* no force comes back */
    }
    const delay_budget budget = delay_budget_of(rig);
    std::string line;
    for (const delay_part &part : budget.parts()) {
        char text[60];
        std::snprintf(text, sizeof text, "%.3g", part.delay_ms);
        line += (line.empty() ? "" : " + ") + std::string(part.name) + " " + text;
    }
    std::printf("  %-14s %s = %.4g ms%s\n", "delay", line.c_str(), budget.total_ms(),
                scheduled_delay_words(rig).c_str());
}

void print_schedule(const growth_prediction &prediction)
{
    if (!prediction.schedule.empty()) {
        std::printf(line_format, "schedule", schedule_words(prediction).c_str());
    }
}

std::string exponent_sentence(const growth_prediction &exponent, std::int64_t seed)
{
    if (!exponent.growth_per_s) {
        return "undetermined, " + exponent.why_not;
    }
    const std::optional<bool> stable = is_stable(exponent);
    char text[160];
    std::snprintf(text, sizeof text, ", Lyapunov exponent %+.6f /s (+-%.1g) over %lld ticks, seed %lld",
                  *exponent.growth_per_s, exponent.ci95_per_s, static_cast<long long>(exponent.ticks),
                  static_cast<long long>(seed));
    return (stable ? stability_word(*stable) : "undetermined") + text;
}

void print_because(const stability_verdict &verdict)
{
    std::printf(line_format, verdict_name(verdict.kind), verdict.because.c_str());
}

void print_unlike_eigenvalues(const std::string &rig_name, const stability_verdict &verdict, double spectral_radius,
                              double growth_per_s)
{
    std::printf("%s: %s\n", rig_name.c_str(), verdict_name(verdict.kind));
    print_because(verdict);
    std::printf("  %-14s spectral radius %.9f, growth %+.6f /s: not what decides here\n", "eigenvalues",
                spectral_radius, growth_per_s);
}

nlohmann::json growth_beside(const stability_verdict &verdict, const nlohmann::json &growth_per_s)
{
    const bool goes_other_way =
        growth_per_s.is_number() && verdict.is_stable && *verdict.is_stable != (growth_per_s.get<double>() < 0.0);
    return goes_other_way ? nlohmann::json() : growth_per_s;
}

void print_margin(const stability_margin &margin)
{
    if (const std::string words = margin_words(margin); !words.empty()) {
        std::printf(line_format, "margin", words.c_str());
    }
}

void print_peaks(const motion_evidence &motion)
{
    std::printf("  %-14s %s N measured at %.3f s", "peak force", four_digits(motion.measured_peak.force_N).c_str(),
                motion.measured_peak.at_s);
    if (motion.true_peak) {
        std::printf(", %s N in the sensor's spring at %.3f s", four_digits(motion.true_peak->force_N).c_str(),
                    motion.true_peak->at_s);
    }
    std::printf("\n");
}

int check_exit_code(const rig_arguments &arguments, const stability_verdict &verdict, const stability_margin &margin)
{
    constexpr int exit_unsafe = 1;
    return arguments.check && !is_safe(verdict, margin, arguments.check_margin_ms) ? exit_unsafe : 0;
}

nlohmann::json answer_json(const rig &rig, const stability_verdict &verdict, const stability_margin &margin)
{
    return {{"verdict", verdict_name(verdict.kind)},
            {"stable", or_null(verdict.is_stable)},
            {"because", verdict.because},
            {"caveat", verdict.caveat.empty() ? nlohmann::json() : nlohmann::json(verdict.caveat)},
            {"advice", verdict.advice.empty() ? nlohmann::json() : nlohmann::json(verdict.advice)},
            {"growth", growth_json(verdict.growth)},
            {"doubling_time_s", doubling_json(verdict)},
            {"margin", margin_json(margin)},
            {"assumed", assumed_json(rig)},
            {"delay_budget", delay_budget_json(rig)}};
}

nlohmann::json prediction_json(const growth_prediction &prediction)
{
    static const char *const sources[] = {nullptr, "eigenvalues", "contact", "lyapunov_exponent",
                                          "run",   "free_flight"};
    const char *const source = sources[static_cast<int>(prediction.source)];
    nlohmann::json schedule = nlohmann::json::array();
    for (const scheduled_growth &loop : prediction.schedule) {
        schedule.push_back({{"from_s", loop.from_s},
                            {"dead_time_ms", loop.dead_time_ms},
                            {"stiffness_N_per_m", loop.stiffness_N_per_m},
                            {"growth_per_s", or_null(loop.growth_per_s)},
                            {"growth_ci95_per_s", loop.ci95_per_s},
                            {"stable", or_null(loop.is_stable)}});
    }
    return {
        {"growth_per_s", or_null(prediction.growth_per_s)},
        {"growth_ci95_per_s", prediction.ci95_per_s},
        {"stable", or_null(is_stable(prediction))},
        {"source", source != nullptr ? nlohmann::json(source) : nlohmann::json()},
        {"ticks", prediction.ticks},
        {"why_not_predicted", prediction.why_not.empty() ? nlohmann::json() : nlohmann::json(prediction.why_not)},
        {"schedule", schedule}};
}

nlohmann::json stop_json(const std::optional<run_stop> &stop)
{
    if (!stop) {
        return nullptr;
    }
    return {{"cause", stop_cause_name(stop->cause)}, {"after_s", stop->after_s}};
}

nlohmann::json doubling_json(const stability_verdict &verdict)
{
    return verdict.growth && verdict.growth->growth_per_s > 0.0 ? nlohmann::json(verdict.growth->factor_time_s())
                                                                : nlohmann::json();
}

nlohmann::json bounces_json(const std::optional<bounce_finding> &bounces)
{
    if (!bounces) {
        return nullptr;
    }
    return {{"count", bounces->count},
            {"restitution", bounces->restitution},
            {"restitution_range", {bounces->restitution_lowest, bounces->restitution_highest}},
            {"energy_J", bounces->energy_J},
            {"driven", bounces->is_driven}};
}

nlohmann::json tracking_json(const motion_evidence &motion)
{
    if (!motion.has_run) {
        return nullptr;
    }
    return {
        {"rms_m", motion.tracking.rms_m}, {"peak_m", motion.tracking.peak_m}, {"range_m", motion.tracking.range_m}};
}

nlohmann::json margin_json(const stability_margin &margin)
{
    const std::string words = margin_words(margin);
    nlohmann::json again = nlohmann::json::array();
    for (const stable_interval &part : margin.stable_again_ms) {
        again.push_back({part.from, part.to});
    }
    return {{"dead_time_margin_ms", or_null(margin.dead_time_ms)},
            {"dead_time_margin_is_open", margin.is_dead_time_open},
            {"unlimited", margin.is_unlimited},
            {"modulus", or_null(margin.modulus)},
            {"stable_again_ms", again},
            {"stable_again_is_open", margin.is_again_open},
            {"sentence", words.empty() ? nlohmann::json() : nlohmann::json(words)},
            {"note", margin.note.empty() ? nlohmann::json() : nlohmann::json(margin.note)}};
}

nlohmann::json assumed_json(const rig &rig)
{
    nlohmann::json list = nlohmann::json::array();
    for (const assumption &one : assumptions_of(rig)) {
        list.push_back({{"key", one.key}, {"value", one.value}});
    }
    return list;
}

nlohmann::json delay_budget_json(const rig &rig)
{
    const delay_budget budget = delay_budget_of(rig);
    nlohmann::json json;
    for (const delay_part &part : budget.parts()) {
        json[std::string(part.key)] = part.delay_ms;
    }
    json["total_ms"] = budget.total_ms();
    json["scheduled"] = nlohmann::json::array();
    for (const scheduled_delay &later : delays_of_schedule(rig)) {
        json["scheduled"].push_back({{"from_s", later.from_s}, {"total_ms", later.total_ms}});
    }
    return json;
}

nlohmann::json peaks_json(const motion_evidence &motion)
{
    nlohmann::json json = {{"measured", peak_json(motion.measured_peak)}, {"true", nullptr}};
    if (motion.true_peak) {
        json["true"] = peak_json(*motion.true_peak);
    }
    return json;
}

} // namespace berth
