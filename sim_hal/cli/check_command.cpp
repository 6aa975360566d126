#include <cstdio>
#include <nlohmann/json.hpp>

#include "../compensated.h"
#include "../plausibility.h"
#include "../stability/compensation_states.h"
#include "bounce_report.h"
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

void print_implausible(const std::vector<implausible_value> &found)
{
    for (const implausible_value &one : found) {
        std::printf("  %-14s %s: %s\n  %-14s %s\n  %-14s %s\n", "implausible", one.key.c_str(), one.what.c_str(), "",
                    one.why.c_str(), "", one.advice.c_str());
    }
    if (found.empty()) {
        std::printf("  %-14s no value is implausible\n", "values");
    }
}

} // namespace

int check_command(const rig_arguments &arguments)
{
    const chosen_rig chosen = choose_rig(arguments);
    const rig &rig = chosen.rig;
    refuse_unstated(rig, arguments.rig);
    const std::vector<implausible_value> found = implausible_values(rig);
    const model_answer answer = answer_of(rig);
    const stability_verdict verdict = answer.verdict();
    const bounce_answer bounce = answer_bounce(rig, {});
    if (arguments.json) {
        nlohmann::json json = answer_json(rig, verdict, answer.margin);
        json["prediction"] = prediction_json(answer.worst.prediction);
        json["rig"] = rig.name;
        json["robot"] = robot_as_json(chosen);
        json["implausible"] = as_json(found);
        json["bounce"] = bounce_json(bounce);
        print_json(json);
    } else {
        std::printf("%s: %s\n", rig.name.c_str(), rig.description.c_str());
        print_implausible(found);
        print_assumptions(rig);
        print_verdict(verdict);
        print_margin(answer.margin);
        print_bounce(bounce);
        print_delay_budget(rig);
    }
    return found.empty() && verdict.is_stable == std::optional<bool>(true) ? 0 : exit_doubtful;
}

} // namespace berth
