#include "step_stage.h"

#include <algorithm>

#include "../../hal/rig/keys.h"
#include "../../hal/rig/units.h"

namespace berth
{

namespace
{

double value_in(const rig &of, const std::string &key)
{
    const rig_key *const known = find_key(key);
    rig copy = of;
    return known != nullptr && known->type == key_type::number ? *static_cast<double *>(known->member(copy)) : 0.0;
}

void add_value(stage_entry &entry, const rig &given, const std::string &key, double measured,
               std::optional<double> ci95)
{
    entry.values.push_back({key, std::string(unit_of(key)), measured, value_in(given, key), ci95});
}

const block_diagnosis *robot_of(const diagnosis &found)
{
    const auto robot = std::find_if(found.blocks.begin(), found.blocks.end(),
                                    [](const block_diagnosis &one) { return one.block == block::robot; });
    return robot == found.blocks.end() ? nullptr : &*robot;
}

std::string names_of(const std::vector<cause> &causes)
{
    std::string words;
    for (const cause &one : causes) {
        words += (words.empty() ? "" : ", ") + std::string(one.effect->name);
    }
    return words.empty() ? "no cause" : words;
}

/* Rivals explain the reports as well: the best one is proposed, and all are named. */
std::string words_of(const block_diagnosis &robot)
{
    switch (robot.verdict) {
    case verdict::nothing_detectable:
        return "the robot moves as the rig file says";
    case verdict::named:
        return "the rig file is wrong about " + names_of(robot.causes);
    case verdict::one_of: {
        std::string words = "the rig file is wrong about " + names_of(robot.causes);
        for (const alternative &one : robot.alternatives) {
            words += (&one == &robot.alternatives.front() ? "; or about " : ", ") + std::string(one.effect->name);
        }
        return words + ", which would look the same in these reports";
    }
    default:
        return "the diagnosis of the robot is " +
               std::string(verdict_names[static_cast<std::size_t>(robot.verdict)]) + ": " + names_of(robot.causes);
    }
}

} // namespace

stage_entry step_entry(const diagnosis &found, const rig &given)
{
    stage_entry entry;
    entry.stage = stage::step;
    const block_diagnosis *const robot = robot_of(found);
    if (robot == nullptr) {
        entry.because = "the log does not tell the robot's motion";
        return entry;
    }
    const bool is_clear = robot->verdict == verdict::nothing_detectable || robot->verdict == verdict::named ||
                          robot->verdict == verdict::one_of;
    entry.outcome = is_clear ? stage_outcome::passed : stage_outcome::failed;
    bool tells_dead_time = false;
    for (const cause &one : robot->causes) {
        for (const parameter_estimate &parameter : one.parameters) {
            add_value(entry, given, parameter.key, parameter.value, parameter.ci95);
            tells_dead_time = tells_dead_time || parameter.key == "robot.dead_time_ms";
            if (is_clear) {
                entry.proposed.emplace_back(parameter.key, parameter.value);
            }
        }
    }
    if (!tells_dead_time && is_clear) {
        add_value(entry, given, "robot.dead_time_ms", value_in(found.extended, "robot.dead_time_ms"), {});
    }
    entry.because = words_of(*robot);
    return entry;
}

stage_entry judge_step(const stage_request &request, const stage_rigs &rigs, const stage_run &run)
{
    const run_stop &stop = run.motion.stop;
    if (!run.motion.has_run || stop.is_early()) {
        stage_entry entry;
        entry.stage = stage::step;
        entry.because = run.motion.has_run ? std::string("the loop was stopped: ") + stop_cause_name(stop.cause)
                                           : "the loop never ran";
        return entry;
    }
    diagnosis_request wanted;
    wanted.records = {request.logs.empty() ? stage_log(request) : request.logs.front()};
    wanted.rig = rigs.told;
    wanted.progress = request.progress;
    return step_entry(diagnose(wanted), rigs.told);
}

} // namespace berth
