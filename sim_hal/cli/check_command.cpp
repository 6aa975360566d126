#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "../compensated.h"
#include "../plausibility.h"
#include "../stability/compensation_states.h"
#include "../start_trial.h"
#include "bounce_report.h"
#include "colour.h"
#include "commands.h"
#include "robot_choice.h"
#include "verdict_report.h"

namespace berth
{

namespace
{

constexpr int exit_doubtful = 1;

nlohmann::json as_json(const std::vector<implausible_value> &found)
{
    nlohmann::json list = nlohmann::json::array();
    for (const implausible_value &one : found) {
        list.push_back({{"key", one.key}, {"what", one.what}, {"why", one.why}, {"advice", one.advice}});
    }
    return list;
}

nlohmann::json as_json(const start_trial &start)
{
    return {{"ran", start.has_run}, {"stopped", stop_json(start.stop)}, {"because", trial_words(start)}};
}

/* Filled up to the column of the text. */
std::string title(ink colour, const std::string &name)
{
    constexpr std::size_t width = 14;
    return coloured(stdout, colour, name) + std::string(width - std::min(width, name.size()), ' ');
}

void print_implausible(const std::vector<implausible_value> &found)
{
    for (const implausible_value &one : found) {
        std::printf("  %s %s: %s\n  %-14s %s\n  %-14s %s\n", title(ink::yellow, "implausible").c_str(),
                    one.key.c_str(), one.what.c_str(), "", one.why.c_str(), "", one.advice.c_str());
    }
    if (found.empty()) {
        std::printf("  %s no value is implausible\n", title(ink::green, "values").c_str());
    }
}

} // namespace

int check_command(const rig_arguments &arguments)
{
    const chosen_rig chosen = choose_rig(arguments);
    const rig &rig = chosen.rig;
    refuse_unstated(rig, arguments.rig);
    const std::vector<implausible_value> found = implausible_values(rig);
    model_answer answer = answer_of(rig);
    stability_verdict verdict = answer.verdict();
    const bounce_answer bounce = answer_bounce(rig, {});
    const start_trial start = try_start(rig);
    if (!start.has_run) {
        answer.margin = {}; /* of no loop */
        verdict.caveat = "of the loop once it runs: as it is, the run of this rig does not start";
    }
    const bool is_known_to_grow = verdict.is_stable == std::optional<bool>(false);
    const bool stops = !start.is_good() && !(start.has_run && is_known_to_grow); /* which is the verdict itself */
    if (arguments.json) {
        nlohmann::json json = answer_json(rig, verdict, answer.margin);
        json["prediction"] = prediction_json(answer.worst.prediction);
        json["rig"] = rig.name;
        json["robot"] = robot_as_json(chosen);
        json["implausible"] = as_json(found);
        json["start"] = as_json(start);
        json["bounce"] = bounce_json(bounce);
        print_json(json);
    } else {
        std::printf("%s: %s\n", rig.name.c_str(), rig.description.c_str());
        print_implausible(found);
        if (stops) {
            std::printf("  %s %s\n  %-14s clear what stops it, and look at `berth run`\n",
                        title(ink::red, start.has_run ? "stops" : "does not start").c_str(),
                        trial_words(start).c_str(), "");
        }
        print_assumptions(rig);
        print_verdict(verdict);
        print_margin(answer.margin);
        print_bounce(bounce);
        print_delay_budget(rig);
    }
    return !stops && found.empty() && verdict.is_stable == std::optional<bool>(true) ? 0 : exit_doubtful;
}

} // namespace berth
