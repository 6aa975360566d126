#include <cstdio>
#include <nlohmann/json.hpp>

#include "../../hal/rig/beam.h"
#include "../../hal/rig/given.h"
#include "../../hal/rig/rig_file.h"
#include "../compensated.h"
#include "../compensation/chooser.h"
#include "../recommendation.h"
#include "../stability/arm_loop.h"
#include "commands.h"
#include "progress_line.h"
#include "robot_choice.h"
#include "verdict_report.h"

namespace berth
{

namespace
{

nlohmann::json as_json(const choice &made, const method_verdict &verdict)
{
    nlohmann::json trials = nlohmann::json::array();
    for (std::size_t i = 0; i < verdict.trials.size(); i++) {
        const trial_result &trial = verdict.trials[i];
        trials.push_back({{"rig", made.differences[i].name},
                          {"ran", trial.ran},
                          {"bounded", trial.is_bounded},
                          {"error", trial.error},
                          {"robot_error", trial.robot_error},
                          {"peak_error_m", trial.peak_error_m},
                          {"peak_force_N", trial.peak_force_N},
                          {"limited_ticks", trial.limited_ticks}});
    }
    return {{"method", verdict.method.name}, {"settings", verdict.method.settings}, {"robust", verdict.is_robust},
            {"error", verdict.error},        {"worst_error", verdict.worst_error},  {"trials", trials}};
}

void print_dissipator(const choice_request &request)
{
    if (request.rig.object.kind != object_kind::gripped) {
        return; /* no eigenvalues to design one from */
    }
    char margin[80];
    std::snprintf(margin, sizeof margin, "%g ms of dead time and %g dB of force", request.margin.dead_time_ms,
                  request.margin.gain_dB);
    const auto damping_N_s_per_m = least_damping(request.rig, request.margin);
    if (!damping_N_s_per_m) {
        std::printf("no dissipation leaves a margin of %s\n", margin);
    } else if (*damping_N_s_per_m == 0.0) {
        std::printf("the loop has a margin of %s without dissipation\n", margin);
    } else {
        std::printf("the least dissipation for a margin of %s: %.4g N s/m\n", margin, *damping_N_s_per_m);
    }
}

bool holds(const trial_result &trial)
{
    return trial.ran && trial.is_bounded;
}

void print_table(const choice &made)
{
    std::printf("distance of the manipulator's motion to the one without dead time, as a share of its swing,\n"
                "and of the robot to where the manipulator is\n");
    std::printf("  %-34s %10s %10s %10s  %s\n", "method", "robot", "as given", "worst", "on a rig with");
    for (const method_verdict &verdict : made.methods) {
        if (verdict.trials.empty()) {
            std::printf("  %-34s %10s\n", verdict.method.name.c_str(), "cannot be");
            continue;
        }
        const std::string &where = made.differences[verdict.worst].name;
        const bool as_told = holds(verdict.trials.front());
        char robot[20];
        char error[20];
        char worst[20];
        std::snprintf(robot, sizeof robot, "%.2f %%", 100.0 * verdict.trials.front().robot_error);
        std::snprintf(error, sizeof error, "%.2f %%", 100.0 * verdict.error);
        std::snprintf(worst, sizeof worst, "%.2f %%", 100.0 * verdict.worst_error);
        std::printf("  %-34s %10s %10s %10s  %s\n", verdict.method.name.c_str(), as_told ? robot : "-",
                    as_told ? error : "diverges", verdict.is_robust ? worst : "diverges", where.c_str());
    }
}

std::string percent(double share)
{
    char text[40];
    std::snprintf(text, sizeof text, share < 1.0 ? "%.1f" : "%.0f", 100.0 * share);
    return text;
}

/* "*": a limit acted, "div": it stopped, or swung twice as far as it should. */
std::string cell_of(const trial_result &trial)
{
    return (holds(trial) ? percent(trial.error) : "div") + (trial.limited_ticks > 0 ? "*" : "");
}

std::string robot_cell_of(const trial_result &trial)
{
    return holds(trial) ? percent(trial.robot_error) : "-";
}

/* Every method on every rig. */
void print_each(const choice &made)
{
    std::printf("distance to the motion without dead time in %% of its swing, as given (0) and on rigs with\n");
    for (std::size_t i = 1; i < made.differences.size(); i++) {
        std::printf("  %2zu  %s\n", i, made.differences[i].name.c_str());
    }
    std::printf("robot: from where the manipulator is, as given\n"
                "div: it was stopped, or swung twice as far as it should; *: a limit acted\n%-34s robot ",
                "");
    for (std::size_t i = 0; i < made.differences.size(); i++) {
        std::printf("%6zu ", i);
    }
    std::printf("\n");
    for (const method_verdict &verdict : made.methods) {
        std::printf("%-34s", verdict.method.name.c_str());
        if (!verdict.trials.empty()) {
            std::printf("%6s ", robot_cell_of(verdict.trials.front()).c_str());
        }
        for (const trial_result &trial : verdict.trials) {
            std::string cell = cell_of(trial);
            cell += cell.back() == '*' ? "" : " ";
            std::printf("%7s", cell.c_str());
        }
        std::printf("\n");
    }
}

/* As a shell takes it for one word. */
std::string shell_word(const std::string &text)
{
    constexpr const char *plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./=+:,-";
    if (!text.empty() && text.find_first_not_of(plain) == std::string::npos) {
        return text;
    }
    std::string quoted = "'";
    for (const char c : text) {
        quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    }
    return quoted + "'";
}

/* Ends with 0 if the same rig with these settings is stable. */
std::string check_command(const compensate_arguments &arguments, const std::vector<std::string> &settings)
{
    std::string line = "build/berth eigen " + shell_word(arguments.rig);
    if (!arguments.robot.empty()) {
        line += " --robot " + shell_word(arguments.robot);
    }
    for (const auto *const list : {&arguments.overrides, &settings}) {
        for (const std::string &one : *list) {
            line += " --set " + shell_word(one);
        }
    }
    return line + " --check";
}

std::string setting_of(const helpful_change &change)
{
    char number[40];
    std::snprintf(number, sizeof number, "%.10g", change.to);
    return change.key + "=" + number;
}

nlohmann::json as_json(const std::vector<unsafe_method> &passed_over)
{
    nlohmann::json list = nlohmann::json::array();
    for (const unsafe_method &one : passed_over) {
        list.push_back({{"method", one.name}, {"because", one.because}});
    }
    return list;
}

void print_recommendation(const choice &made, const choice_request &request, const compensate_arguments &arguments)
{
    const recommendation found = recommend(made, request.rig);
    const method_verdict *const best = found.best;
    for (const unsafe_method &one : found.passed_over) {
        std::printf("passed over: %s, unstable%s: %s\n", one.name.c_str(),
                    request.rig.object.kind == object_kind::contact ? " while the tool stays in contact" : "",
                    one.because.c_str());
    }
    if (best != nullptr) {
        std::printf("recommended: %s; price in fidelity %.2f %%, at worst %.2f %%\n", best->method.name.c_str(),
                    100.0 * best->error, 100.0 * best->worst_error);
        for (const std::string &setting : best->method.settings) {
            std::printf("  --set %s\n", setting.c_str());
        }
        std::printf("  check it: %s\n", check_command(arguments, best->method.settings).c_str());
        return;
    }
    std::printf("REFUSED: no method is robust%s\n", !found.passed_over.empty()      ? ", useful and stable"
                                                    : made.recommended() != nullptr ? " and within half of the swing"
                                                                                    : " on every one of these rigs");
    bool is_any = false;
    for (const helpful_change &change : what_would_help(request)) {
        std::vector<std::string> settings = {setting_of(change)};
        settings.insert(settings.end(), change.method.settings.begin(), change.method.settings.end());
        if (why_unsafe(request.rig, settings)) {
            continue;
        }
        is_any = true;
        std::printf("  it would be with %s from %g to %g: %s\n  check it: %s\n", change.key.c_str(), change.from,
                    change.to, change.method.name.c_str(), check_command(arguments, settings).c_str());
    }
    if (!is_any) {
        std::printf("  halving dead time, stiffness or mass would not be enough either\n");
    }
}

} // namespace

int compensate_command(const compensate_arguments &arguments)
{
    choice_request request;
    request.rig = choose_rig(arguments).rig;
    refuse_unstated(request.rig, arguments.rig);
    refuse_arm(request.rig);
    refuse_beam(request.rig);
    request.dead_time_share = 0.01 * arguments.dead_time_percent;
    request.stiffness_share = 0.01 * arguments.stiffness_percent;
    request.mass_share = 0.01 * arguments.mass_percent;
    request.noise_N = arguments.noise_N;
    request.duration_s = arguments.duration_s;
    request.margin = {arguments.margin_ms, arguments.margin_dB};
    const choice made = choose_compensation(request);
    if (arguments.json) {
        nlohmann::json methods = nlohmann::json::array();
        for (const method_verdict &verdict : made.methods) {
            methods.push_back(as_json(made, verdict));
        }
        nlohmann::json json = {{"rig", request.rig.name},
                               {"recommended", nullptr},
                               {"check", nullptr},
                               {"impossible", made.impossible},
                               {"methods", methods},
                               {"assumed", assumed_json(request.rig)},
                               {"delay_budget", delay_budget_json(request.rig)}};
        const recommendation found = recommend(made, request.rig);
        json["passed_over"] = as_json(found.passed_over);
        if (found.best != nullptr) {
            json["recommended"] = found.best->method.name;
            json["check"] = check_command(arguments, found.best->method.settings);
        }
        std::printf("%s\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
        return 0;
    }
    std::printf("%s: %s\n", request.rig.name.c_str(), request.rig.description.c_str());
    print_assumptions(request.rig);
    print_delay_budget(request.rig);
    print_dissipator(request);
    if (arguments.each) {
        print_each(made);
    } else {
        print_table(made);
    }
    for (const std::string &name : made.impossible) {
        std::printf("  not tried: %s, which no rig may have\n", name.c_str());
    }
    print_recommendation(made, request, arguments);
    return 0;
}

} // namespace berth
