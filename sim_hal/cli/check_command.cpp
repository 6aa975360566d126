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
    const growth_prediction predicted = predict_growth(rig);
    const bool grows = predicted.growth_per_s.value_or(0.0) > 0.0 || predicted.gains_by_bounces();
    const bool is_run = !compensation_is_linear(rig) || is_judged_by_runs(rig);
    const stability_verdict verdict =
        is_run ? verdict_by_runs(rig) : judge(predicted, grows ? advise(rig) : stability_advice());
    const bool is_unstable = grows || verdict.is_stable == std::optional<bool>(false);
    const stability_margin margin = is_unstable ? stability_margin() : margin_of(rig);
    const bounce_answer bounce = answer_bounce(rig, {});
    if (arguments.json) {
        nlohmann::json json = answer_json(rig, verdict, margin);
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
        print_margin(margin);
        print_bounce(bounce);
        print_delay_budget(rig);
    }
    return found.empty() && verdict.is_stable == std::optional<bool>(true) ? 0 : exit_doubtful;
}

} // namespace berth
