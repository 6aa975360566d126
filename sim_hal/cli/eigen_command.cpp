#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "../../firmware/compensation/compensation.h"
#include "../compensated.h"
#include "../stability/compensation_states.h"
#include "../stability/lyapunov.h"
#include "../stability/spectrum.h"
#include "../start_trial.h"
#include "amplitude.h"
#include "bounce_report.h"
#include "colour.h"
#include "commands.h"
#include "compensated_report.h"
#include "gains_report.h"
#include "json_or_null.h"
#include "robot_choice.h"
#include "verdict_report.h"

namespace berth
{

namespace
{

nlohmann::json as_json(const spectrum &spectrum, bool is_free)
{
    nlohmann::json eigenvalues = nlohmann::json::array();
    for (const mode &mode : spectrum.modes) {
        eigenvalues.push_back({mode.z.real(), mode.z.imag()});
    }
    return {{"eigenvalues", eigenvalues},
            {"spectral_radius", spectrum.spectral_radius},
            {"growth_per_s", spectrum.growth_per_s},
            {"stable", stable_json(spectrum.growth_per_s, spectrum.spectral_radius, is_free)}};
}

void print_modes(const char *title, const spectrum &spectrum)
{
    std::printf("%s\n  %-26s %12s %12s %12s %10s\n", title, "z", "|z|", "growth /s", "Hz", "damping");
    for (const mode &mode : spectrum.modes) {
        if (mode.z.imag() < 0.0) {
            continue; /* the other one of the pair stands for both */
        }
        const char *const sign = mode.z.imag() > 0.0 ? "+-" : "  ";
        std::printf("  %+.8f %s %.8fi  %12.9f %12.6f %12.6f %10.6f\n", mode.z.real(), sign, mode.z.imag(),
                    std::abs(mode.z), mode.growth_per_s, mode.frequency_Hz, mode.damping_ratio);
    }
}

nlohmann::json as_json(const settled_rig &at)
{
    nlohmann::json json = as_json(loop_spectrum(at.linear), drifts_freely(at.linear));
    json["stable"] = unless_guess(at.has_settled, json["stable"]);
    return json;
}

nlohmann::json spectra_json(const rig &steady, double amplitude_m)
{
    nlohmann::json json = as_json(settle_at(steady, amplitude_m));
    json["rig"] = steady.name;
    json["left_out"] = left_out(steady, amplitude_m);
    json["describing_function"] = describing_function_json(steady, amplitude_m);
    const bool is_arm = steady.firmware.arm.kind != ARM_NONE;
    json["manipulator"] =
        as_json(manipulator_spectrum(steady), !is_arm && steady.firmware.manipulator.stiffness_N_per_m == 0.0);
    json["coupled"] = as_json(coupled_spectrum(steady), drifts_freely(steady));
    return json;
}

void print_spectra(const rig &steady, const spectrum &loop, const char *loop_title)
{
    print_modes(loop_title, loop);
    const bool is_arm = steady.firmware.arm.kind != ARM_NONE;
    print_modes(is_arm ? "arm alone" : "manipulator alone", manipulator_spectrum(steady));
    print_modes(is_arm ? "arm and object coupled, without dead time"
                       : "manipulator and object coupled, without dead time",
                coupled_spectrum(steady));
}

/* `title` goes before it. */
void print_spectrum(const char *title, const settled_rig &at, const spectrum &loop)
{
    const bool is_free = drifts_freely(at.linear);
    const nlohmann::json stable = stable_json(loop.growth_per_s, loop.spectral_radius, is_free);
    std::printf("%s: %s, spectral radius %.9f, growth %+.6f /s%s\n", title,
                !stable.is_null() ? stability_word(stable == true).c_str()
                : is_free         ? "undetermined (no spring holds manipulator or object: z = 1)"
                                  : "undetermined (no more than rounding)",
                loop.spectral_radius, loop.growth_per_s, guess_text(at.has_settled));
}

/* Where more than the eigenvalues decides, the verdict stands in front of them, and its reason below. A verdict by
 * runs that agrees with them has its own growth. */
void print_loop(const rig &rig, const settled_rig &at, const spectrum &loop, const stability_verdict &verdict,
                bool is_by_runs)
{
    const nlohmann::json of_eigenvalues =
        stable_json(loop.growth_per_s, loop.spectral_radius, drifts_freely(at.linear));
    const bool is_of_eigenvalues = (!at.has_settled && !is_judged_by_runs(rig)) || drifts_freely(at.linear) ||
                                   or_null(verdict.is_stable) == of_eigenvalues;
    if (is_of_eigenvalues) {
        print_spectrum(rig.name.c_str(), at, loop);
        if (is_by_runs) {
            print_because(verdict);
        }
        return;
    }
    print_unlike_eigenvalues(rig.name, verdict, loop.spectral_radius, loop.growth_per_s);
}

/* What was asked: `chosen` holds the loop that decides, of a rig that schedules a change the worst one. */
struct question {
    chosen_rig chosen;
    rig stated;
    double amplitude_m;
    model_answer found;
    stability_verdict verdict;
};

question ask(const varying_arguments &arguments, chosen_rig chosen, double amplitude_m)
{
    settle_at(chosen.rig, amplitude_m); /* says here what is wrong with the amplitude */
    const rig stated = chosen.rig;
    model_answer found = answer_of(stated, predictor_at(amplitude_m, arguments.ticks), arguments.amplitude_m);
    chosen.rig = found.worst.rig;
    if (!found.by_runs && amplitude_m > 0.0 && is_slow_to_find(chosen.rig) &&
        is_stable(found.worst.prediction) != std::optional<bool>(false)) {
        found.margin = margin_of(linear_at(chosen.rig, amplitude_m));
    }
    if (never_runs(chosen.rig, found.worst.prediction)) {
        found.margin = {};
    }
    stability_verdict verdict = found.verdict();
    add_caveat_of_run(verdict, stated);
    return {chosen, stated, amplitude_m, found, verdict};
}

void print_answer(const question &asked)
{
    print_caveat(asked.verdict);
    print_schedule(asked.found.worst.prediction);
    print_delay_budget(asked.stated);
    print_margin(asked.found.margin);
    if (!asked.verdict.advice.empty()) {
        std::printf("  %-14s %s\n", "advice", asked.verdict.advice.c_str());
    }
}

nlohmann::json as_json(const question &asked)
{
    nlohmann::json json = answer_json(asked.stated, asked.verdict, asked.found.margin);
    json["prediction"] = prediction_json(asked.found.worst.prediction);
    json["robot"] = robot_as_json(asked.chosen);
    return json;
}

/* Null where the interval of the exponent holds 0. */
nlohmann::json exponent_stable_json(const lyapunov_exponent &exponent)
{
    if (std::abs(exponent.growth_per_s) < exponent.ci95_per_s) {
        return nullptr;
    }
    return exponent.growth_per_s <= 0.0;
}

nlohmann::json as_json(const lyapunov_exponent &exponent, bool has_settled)
{
    return {{"eigenvalues", nullptr},
            {"spectral_radius", nullptr},
            {"growth_per_s", exponent.growth_per_s},
            {"growth_ci95_per_s", exponent.ci95_per_s},
            {"stable", unless_guess(has_settled, exponent_stable_json(exponent))},
            {"ticks", exponent.ticks}};
}

void print_exponent(const lyapunov_exponent &exponent, std::int64_t seed, bool has_settled)
{
    const growth_prediction as_prediction{
        exponent.growth_per_s, {}, exponent.ci95_per_s, prediction_source::lyapunov_exponent, exponent.ticks};
    std::printf("%s%s\n", exponent_sentence(as_prediction, seed).c_str(), guess_text(has_settled));
}

void print_robot(const chosen_rig &chosen)
{
    if (chosen.robot) {
        std::printf("  robot %s\n", robot_sentence(robot_as_json(chosen)).c_str());
    }
}

int steady_eigen(const question &asked, const varying_arguments &arguments)
{
    const auto &[chosen, stated, amplitude_m, found, verdict] = asked;
    const rig &rig = chosen.rig;
    const settled_rig own = settle_at(rig, amplitude_m);
    std::optional<settled_rig> lower_end;
    if (chosen.dead_time_band) {
        lower_end = settle_at(chosen.at_lower_end(), amplitude_m);
    }
    const spectrum loop = loop_spectrum(own.linear);
    if (arguments.json) {
        nlohmann::json json = spectra_json(rig, amplitude_m);
        json.update(as_json(asked));
        json["growth_per_s"] = found.by_runs ? growth_beside(verdict, json["growth_per_s"]) : json["growth_per_s"];
        json["bounce"] = bounce_json(answer_bounce(rig, {}));
        json["lower_end"] = nullptr;
        if (lower_end) {
            json["lower_end"] = as_json(*lower_end);
            json["lower_end"]["dead_time_ms"] = chosen.dead_time_band->from;
        }
        print_json(json);
        return check_exit_code(arguments, verdict, found.margin);
    }
    print_assumptions(rig);
    print_loop(rig, own, loop, verdict, found.by_runs.has_value());
    print_answer(asked);
    print_bounce(answer_bounce(rig, {}));
    print_robot(chosen);
    print_describing_function(describing_function_json(rig, amplitude_m));
    if (lower_end) {
        char title[60];
        std::snprintf(title, sizeof title, "  dead time %g ms, the lower end", chosen.dead_time_band->from);
        print_spectrum(title, *lower_end, loop_spectrum(lower_end->linear));
    }
    print_spectra(in_contact(rig), loop,
                  rig.object.kind == object_kind::contact ? "loop with dead time, in contact"
                                                          : "loop with dead time");
    return check_exit_code(arguments, verdict, found.margin);
}

/* Neither eigenvalues nor an exponent: as of a loop that never runs. */
int answer_without_exponent(const question &asked, const varying_arguments &arguments)
{
    if (arguments.json) {
        nlohmann::json json = as_json(asked);
        json.update({{"rig", asked.chosen.rig.name},
                     {"eigenvalues", nullptr},
                     {"spectral_radius", nullptr},
                     {"growth_per_s", nullptr},
                     {"growth_ci95_per_s", nullptr}});
        print_json(json);
    } else {
        print_assumptions(asked.chosen.rig);
        std::printf("%s: %s\n", asked.chosen.rig.name.c_str(),
                    exponent_sentence(asked.found.worst.prediction, asked.chosen.rig.run.seed).c_str());
        print_answer(asked);
    }
    return check_exit_code(arguments, asked.verdict, asked.found.margin);
}

/* No eigenvalues, but an exponent; for comparison those of the loop without what makes it change. */
int varying_eigen(const question &asked, const varying_arguments &arguments)
{
    const auto &[chosen, stated, amplitude_m, found, verdict] = asked;
    const std::int64_t ticks = arguments.ticks;
    const rig &rig = chosen.rig;
    const wake_histogram histogram = load_wake_histogram(rig);
    const struct rig steady = without_variation(rig);
    const settled_rig own = settle_at(rig, amplitude_m);
    const growth_prediction &predicted = found.worst.prediction;
    if (own.has_settled && !predicted.growth_per_s) {
        if (!never_runs(rig, predicted)) {
            throw input_error(predicted.why_not);
        }
        return answer_without_exponent(asked, arguments);
    }
    const lyapunov_exponent exponent =
        own.has_settled ? lyapunov_exponent{*predicted.growth_per_s, predicted.ci95_per_s, predicted.ticks}
                        : exponent_of(own.linear, histogram, ticks);
    std::optional<settled_rig> low;
    std::optional<lyapunov_exponent> lower_end;
    if (chosen.dead_time_band) {
        low = settle_at(chosen.at_lower_end(), amplitude_m);
        lower_end = exponent_of(low->linear, histogram, ticks);
    }
    const std::vector<std::string> effects = what_varies(rig, histogram);
    if (arguments.json) {
        nlohmann::json json = as_json(exponent, own.has_settled);
        json.update(as_json(asked));
        json.update({{"rig", rig.name},
                     {"left_out", left_out(rig, amplitude_m)},
                     {"describing_function", describing_function_json(rig, amplitude_m)},
                     {"lower_end", nullptr},
                     {"seed", rig.run.seed},
                     {"varies", effects},
                     {"bounce", bounce_json(answer_bounce(rig, {}))},
                     {"without", spectra_json(steady, amplitude_m)}});
        if (lower_end) {
            json["lower_end"] = as_json(*lower_end, low->has_settled);
            json["lower_end"]["dead_time_ms"] = chosen.dead_time_band->from;
        }
        print_json(json);
        return check_exit_code(arguments, verdict, found.margin);
    }
    print_assumptions(rig);
    std::printf("%s: ", rig.name.c_str());
    print_exponent(exponent, rig.run.seed, own.has_settled);
    print_answer(asked);
    print_bounce(answer_bounce(rig, {}));
    print_robot(chosen);
    print_describing_function(describing_function_json(rig, amplitude_m));
    if (lower_end) {
        std::printf("  dead time %g ms, the lower end: ", chosen.dead_time_band->from);
        print_exponent(*lower_end, rig.run.seed, low->has_settled);
    }
    for (const std::string &effect : effects) {
        std::printf("  %s\n", effect.c_str());
    }
    const settled_rig without = settle_at(steady, amplitude_m);
    const spectrum loop = loop_spectrum(without.linear);
    print_spectrum("  without", without, loop);
    print_spectra(steady, loop, "loop with dead time, without that");
    return check_exit_code(arguments, verdict, found.margin);
}

} // namespace

int eigen_command(const varying_arguments &arguments)
{
    const chosen_rig chosen = choose_rig(arguments);
    refuse_unstated(chosen.rig, arguments.rig);
    const double amplitude_m = chosen_amplitude_m(arguments, chosen.rig);
    const bool varies = is_time_varying(chosen.rig);
    const bool has_no_exponent = compensation_is_on(&chosen.rig.firmware) && (amplitude_m > 0.0 || varies);
    if (!compensation_is_linear(chosen.rig) || has_no_exponent) {
        tell_left_out(chosen.rig, amplitude_m);
        return answer_compensated_growth(chosen.rig, arguments);
    }
    const question asked = ask(arguments, chosen, amplitude_m);
    tell_left_out(asked.chosen.rig, amplitude_m);
    return varies ? varying_eigen(asked, arguments) : steady_eigen(asked, arguments);
}

} // namespace berth
