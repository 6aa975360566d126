#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "../../firmware/compensation/compensation.h"
#include "../compensated.h"
#include "../rig_limits.h"
#include "../stability/first_order_limit.h"
#include "../stability/limits.h"
#include "../stability/loop_timeline.h"
#include "../stability/physical_parameter.h"
#include "../stability/stable_intervals.h"
#include "../start_trial.h"
#include "../verdict_words.h"
#include "amplitude.h"
#include "bounce_report.h"
#include "commands.h"
#include "compensated_report.h"
#include "gains_report.h"
#include "json_or_null.h"
#include "parameter_report.h"
#include "progress_line.h"
#include "robot_choice.h"
#include "short_number.h"
#include "verdict_report.h"

namespace berth
{

namespace
{

/* The dead times that the robot preset reports, and where in their range the loop is stable. */
struct band_verdict {
    range_ms band;
    std::vector<stable_interval> stable;

    bool is_whole() const { return stable.size() == 1 && stable[0].from == band.from && stable[0].to == band.to; }
};

std::optional<band_verdict> judge_band(const chosen_rig &chosen, const linear_view &linear)
{
    if (!chosen.dead_time_band) {
        return {};
    }
    const auto [from, to] = *chosen.dead_time_band;
    return band_verdict{{from, to}, stable_within(chosen.rig, "robot.dead_time_ms", from, to, linear)};
}

nlohmann::json as_json(const std::optional<band_verdict> &verdict)
{
    if (!verdict) {
        return nullptr;
    }
    return {{"dead_time_band_ms", {verdict->band.from, verdict->band.to}},
            {"stable", verdict->is_whole()       ? "all"
                       : verdict->stable.empty() ? "none"
                                                 : "part"},
            {"stable_intervals_ms", intervals_json(verdict->stable)}};
}

void print_band(const std::optional<band_verdict> &verdict)
{
    if (!verdict) {
        return;
    }
    std::printf("  reported dead time from %g to %g ms: ", verdict->band.from, verdict->band.to);
    if (verdict->stable.empty()) {
        std::printf("unstable over the whole of it");
    } else if (verdict->is_whole()) {
        std::printf("stable over the whole of it");
    } else {
        std::printf("stable over a part of it:");
        for (const stable_interval &interval : verdict->stable) {
            std::printf(" %s", interval_text(interval).c_str());
        }
    }
    std::printf("\n");
}

/* What is told of the loop as a whole, beside its parameters. */
struct loop_verdict {
    growth_prediction predicted; /* with what makes the loop change from tick to tick; the rest is without it */
    double spectral_radius;
    double growth_per_s;
    bool is_stable;
    std::optional<double> margin_ms;
    bool has_no_loop = false; /* it never runs */
    double loop_delay_ms;
    double damping_ratio;
    double first_order_damping_limit;
    std::optional<band_verdict> band;
    std::vector<std::string> left_out; /* what makes the loop change from tick to tick, in words */
    nlohmann::json describing_function;
};

bool has_settled(const loop_verdict &verdict)
{
    return verdict.describing_function.is_null() || verdict.describing_function["settled"].get<bool>();
}

nlohmann::json as_json(const chosen_rig &chosen, const loop_verdict &verdict)
{
    const nlohmann::json stable = unless_guess(has_settled(verdict), verdict.is_stable);
    const bool varies = !verdict.left_out.empty();
    const nlohmann::json without = {
        {"stable", stable}, {"spectral_radius", verdict.spectral_radius}, {"growth_per_s", verdict.growth_per_s}};
    return {
        {"rig", chosen.rig.name},
        {"robot", robot_as_json(chosen)},
        {"left_out", verdict.left_out},
        {"without", varies ? without : nlohmann::json()},
        {"growth_ci95_per_s", verdict.predicted.ci95_per_s},
        {"describing_function", verdict.describing_function},
        {"dead_time_band", as_json(verdict.band)},
        {"stable", stable},
        {"spectral_radius", varies ? nlohmann::json() : nlohmann::json(verdict.spectral_radius)},
        {"growth_per_s", varies ? or_null(verdict.predicted.growth_per_s) : nlohmann::json(verdict.growth_per_s)},
        {"damping_ratio", verdict.damping_ratio},
        {"first_order_damping_limit", verdict.first_order_damping_limit}};
}

void print_loop(const chosen_rig &chosen, const loop_verdict &verdict, const stability_verdict &judged,
                const stability_margin &margin, bool is_run)
{
    const bool varies = !verdict.left_out.empty();
    if (varies) {
        std::printf("%s: %s\n", chosen.rig.name.c_str(),
                    exponent_sentence(verdict.predicted, chosen.rig.run.seed).c_str());
    }
    const bool is_of_loop = varies || judged.is_stable == std::optional<bool>(verdict.growth_per_s < 0.0) ||
                            (!has_settled(verdict) && !is_run);
    const char *const name = is_of_loop ? verdict.is_stable ? "stable" : "unstable" : verdict_name(judged.kind);
    if (is_of_loop) {
        std::printf("%s: %s, spectral radius %.9f, growth %+.6f /s%s\n",
                    varies ? "  the rest is without what changes from tick to tick" : chosen.rig.name.c_str(), name,
                    verdict.spectral_radius, verdict.growth_per_s, guess_text(has_settled(verdict)));
        if (is_run) {
            print_because(judged);
        }
    } else {
        print_unlike_eigenvalues(chosen.rig.name, judged, verdict.spectral_radius, verdict.growth_per_s);
    }
    print_schedule(verdict.predicted);
    if (chosen.robot) {
        std::printf("  robot %s\n", robot_sentence(robot_as_json(chosen)).c_str());
    }
    for (const std::string &effect : verdict.left_out) {
        std::printf("  left out: %s\n", effect.c_str());
    }
    print_describing_function(verdict.describing_function);
    print_band(verdict.band);
    if (margin.is_unlimited ||
        (is_run ? margin.dead_time_ms.has_value() : verdict.is_stable && !verdict.has_no_loop)) {
        print_margin(margin);
    }
    std::printf("  first-order formula: the loop's delay of %s ms takes %s off the coupled damping ratio %s\n",
                short_number(verdict.loop_delay_ms).c_str(), short_number(verdict.first_order_damping_limit).c_str(),
                short_number(verdict.damping_ratio).c_str());
}

} // namespace

int limits_command(const limits_arguments &arguments)
{
    if (!(arguments.change_percent > 0.0 && arguments.change_percent < 100.0)) {
        throw input_error("--change: must be between 0 and 100 %");
    }
    chosen_rig chosen = choose_rig(arguments);
    refuse_unstated(chosen.rig, arguments.rig);
    const berth::rig stated = chosen.rig;
    const double amplitude_m = chosen_amplitude_m(arguments, stated);
    const bool has_arm = stated.firmware.arm.kind != ARM_NONE;
    if (compensation_is_on(&stated.firmware) || (has_arm && amplitude_m == 0.0)) {
        tell_left_out(stated, amplitude_m);
        return answer_compensated_limits(stated, arguments);
    }
    settle_at(stated, amplitude_m); /* says here what is wrong with the amplitude */
    model_answer answer = answer_of(stated, predictor_at(amplitude_m), arguments.amplitude_m);
    chosen.rig = answer.worst.rig;
    loop_verdict verdict{};
    verdict.predicted = answer.worst.prediction;
    if (is_time_varying(chosen.rig)) {
        verdict.left_out = what_varies(chosen.rig, load_wake_histogram(chosen.rig));
        chosen.rig = without_variation(chosen.rig);
    }
    const rig &rig = chosen.rig;
    tell_left_out(rig, amplitude_m);
    const berth::rig own = linear_at(rig, amplitude_m);
    if (drifts_freely(own)) {
        throw input_error(
            "limits: neither manipulator.stiffness_N_per_m nor object.stiffness_N_per_m holds the two "
            "anywhere: they may drift together for ever (z = 1), neither stable nor unstable; give one "
            "of them a stiffness");
    }
    verdict.spectral_radius = spectral_radius_of(own);
    verdict.growth_per_s = std::log(verdict.spectral_radius) / config_period_s(&own.firmware);
    verdict.is_stable = verdict.spectral_radius < 1.0 && !verdict.predicted.gains_by_bounces() &&
                        !verdict.predicted.grows_in_flight();
    verdict.describing_function = describing_function_json(rig, amplitude_m);
    const linear_view linear = linear_view_at(amplitude_m);
    if (amplitude_m > 0.0 && is_slow_to_find(rig) && !arguments.json) {
        std::fprintf(
            stderr,
            "berth: limits: what this effect is like takes milliseconds or more at each value: seconds in all, and "
            "minutes where a grip that gives way rubs as well\n");
    }
    const progress_line progress;
    const std::vector<parameter_limits> parameters =
        limits_of(rig, amplitude_m, [&](std::string_view key) { progress.show("limits: " + std::string(key)); });
    std::optional<double> searched_ms; /* of the dead time */
    std::vector<stable_interval> stable_again_ms;
    bool is_again_open = false;
    for (const parameter_limits &parameter : parameters) {
        if (parameter.key == "robot.dead_time_ms") {
            verdict.margin_ms = dead_time_margin_ms(rig, parameter, linear);
            searched_ms = parameter.to - parameter.value;
            stable_again_ms = stable_beyond(parameter);
            is_again_open = is_open_beyond(parameter);
        }
    }
    progress.show("limits: rates, gains");
    const std::vector<rate_verdict> rates = judge_rates(rig, delays_stay::in_ms, linear);
    const std::vector<rate_verdict> rates_in_ticks = judge_rates(rig, delays_stay::in_ticks, linear);
    const double change = 1e-2 * arguments.change_percent;
    const gain_ranking ranking{change, quality_of(own), find_gains(rig, change, linear)};
    verdict.band = judge_band(chosen, linear);
    verdict.damping_ratio = map_point_of(own).damping_ratio;
    verdict.first_order_damping_limit = first_order_damping_limit(own);
    verdict.loop_delay_ms = 1e3 * loop_delay_s(own);
    progress.show("");

    const bool varies = !verdict.left_out.empty();
    const bool is_run = answer.by_runs.has_value();
    if (never_runs(stated, answer.worst.prediction)) {
        answer.margin = {};
        verdict.has_no_loop = true;
    }
    if (!varies && !is_run && !touches_nothing(rig)) {
        const bool is_open = verdict.is_stable && !verdict.margin_ms;
        answer.margin = {is_open ? searched_ms : verdict.margin_ms,
                         is_open,
                         ranking.now ? ranking.now->margin : std::nullopt,
                         false,
                         {},
                         verdict.is_stable ? stable_again_ms : std::vector<stable_interval>(),
                         is_again_open};
    }
    const bool may_advise = amplitude_m > 0.0 && !verdict.is_stable && !is_run;
    if (const auto nearest = nearest_limit(parameters, false); nearest && may_advise) {
        answer.advice.change = change_to(stated, *nearest, predictor_at(amplitude_m));
    }
    stability_verdict judged = answer.verdict();
    judged.because += left_out_words(verdict.left_out);
    add_caveat_of_run(judged, stated);
    const stability_margin &margin = answer.margin;
    verdict.margin_ms = is_run ? margin.dead_time_ms : verdict.margin_ms;
    const int exit_code = check_exit_code(arguments, judged, margin);
    const bounce_answer bounce = answer_bounce(rig, {"object.stiffness_N_per_m", "robot.dead_time_ms"});
    if (arguments.json) {
        nlohmann::json json = as_json(chosen, verdict);
        json.update(answer_json(stated, judged, margin));
        json["growth_per_s"] = is_run ? growth_beside(judged, json["growth_per_s"]) : json["growth_per_s"];
        json["prediction"] = prediction_json(answer.worst.prediction);
        json["bounce"] = bounce_json(bounce);
        json["rates"] = rates_json(rates);
        json["rates_with_delays_in_ticks"] = rates_json(rates_in_ticks);
        json["buys"] = as_json(ranking);
        json["nearest_limit"] = nearest_limit_json(parameters, verdict.is_stable);
        for (const parameter_limits &parameter : parameters) {
            json["parameters"][std::string(parameter.key)] = parameter_json(parameter);
        }
        print_json(json);
        return exit_code;
    }
    print_assumptions(stated);
    print_loop(chosen, verdict, judged, margin, is_run);
    print_caveat(judged);
    print_delay_budget(stated);
    print_bounce(bounce);
    print_parameters(parameters, scan_at(rig, amplitude_m));
    if (!varies) {
        print_nearest_limit(parameters, verdict.is_stable);
    }
    print_rates("rates in Hz, dead time and delay as they are in ms", rates);
    print_rates("rates in Hz, dead time and delay as many ticks as now", rates_in_ticks);
    print_gains(ranking);
    return exit_code;
}

} // namespace berth
