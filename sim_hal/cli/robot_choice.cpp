#include "robot_choice.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "../../hal/rig/given.h"
#include "../arm/linear_arm.h"
#include "../effects/active.h"
#include "../effects/effect.h"
#include "commands.h"
#include "compensation_choice.h"
#include "short_number.h"

namespace berth
{

std::vector<std::string> left_out(const rig &rig, double amplitude_m)
{
    std::vector<std::string> lines = amplitude_m > 0.0 ? taken_as_at_the_start(rig) : left_out_when_small(rig);
    for (std::string &line : attitude_left_out(rig.firmware.arm)) {
        lines.push_back(std::move(line));
    }
    return lines;
}

void tell_left_out(const rig &rig, double amplitude_m)
{
    for (const std::string &line : left_out(rig, amplitude_m)) {
        std::fprintf(stderr, "berth: %s\n", line.c_str());
    }
}

namespace
{

/* Keys that somebody stated, and that change nothing: one line for each reason. */
void tell_without_effect(const rig &rig)
{
    const auto tell = [&](const std::vector<const char *> &keys, const char *why) {
        std::string stated;
        for (const char *const key : keys) {
            if (is_given(rig, key) && value_of(rig, key) != 0.0) {
                stated += (stated.empty() ? "" : ", ") + std::string(key);
            }
        }
        if (!stated.empty()) {
            std::fprintf(stderr, "berth: %s: without effect, because %s\n", stated.c_str(), why);
        }
    };
    if (touches_nothing(rig)) {
        tell({"object.mass_kg", "object.stiffness_N_per_m", "object.damping_N_s_per_m"},
             "object.kind = \"none\": the robot touches nothing");
    }
    if (rig.robot.clock == robot_clock::locked) {
        tell({"robot.clock_phase_ms", "robot.clock_drift_ppm"},
             "robot.clock = \"locked\"; a clock of its own is robot.clock = \"free\"");
    }
}

std::string range_text(const nlohmann::json &range_ms)
{
    const double from = range_ms.at(0);
    const double to = range_ms.at(1);
    return (from < to ? short_number(from) + " to " : "") + short_number(to) + " ms";
}

/* What a rig file tells the prediction of its robot is not so of the preset's. */
void refuse_model_of_another_robot(const chosen_rig &chosen, const std::vector<std::string> &overrides)
{
    const prediction_config &told = chosen.rig.firmware.prediction;
    const bool is_of_the_file = std::none_of(overrides.begin(), overrides.end(), [](const std::string &setting) {
        return setting.rfind("prediction.dead_time_ms=", 0) == 0;
    });
    if (told.enabled && is_of_the_file && std::isfinite(told.dead_time_ms)) {
        throw input_error("prediction.dead_time_ms: " + short_number(told.dead_time_ms) +
                          " ms in the rig file are its own robot's, not those of " + chosen.robot->name +
                          ": leave the key out, then the preset's count, or --set it");
    }
}

} // namespace

rig chosen_rig::at_lower_end() const
{
    berth::rig lower = rig;
    show_dead_time(lower, dead_time_band->from);
    return lower;
}

chosen_rig choose_rig(const rig_arguments &arguments)
{
    chosen_rig chosen;
    if (is_compensation(arguments.rig)) {
        throw input_error(compensation_for_rig(arguments.rig));
    }
    std::vector<std::string> overrides = compensation_settings(arguments.with);
    overrides.insert(overrides.end(), arguments.overrides.begin(), arguments.overrides.end());
    if (arguments.robot.empty()) {
        chosen.rig = load_rig(arguments.rig, overrides);
        tell_without_effect(chosen.rig);
        return chosen;
    }
    chosen.robot = load_robot(arguments.robot);
    chosen.rig = load_rig(arguments.rig, overrides, &*chosen.robot);
    chosen.dead_time_band = dead_time_band(*chosen.robot, arguments.overrides);
    refuse_model_of_another_robot(chosen, arguments.overrides);
    tell_without_effect(chosen.rig);
    return chosen;
}

chosen_rig choose_rig(const varying_arguments &arguments)
{
    rig_arguments with_jitter = arguments;
    if (!arguments.jitter_file.empty()) {
        with_jitter.overrides.push_back("run.lateness_file=" + arguments.jitter_file);
    }
    if (arguments.seed >= 0) {
        with_jitter.overrides.push_back("run.seed=" + std::to_string(arguments.seed));
    }
    return choose_rig(with_jitter);
}

nlohmann::json robot_as_json(const chosen_rig &chosen)
{
    if (!chosen.robot) {
        return nullptr;
    }
    const robot_preset &robot = *chosen.robot;
    nlohmann::json json = {{"preset", robot.name},
                           {"source", robot.source},
                           {"assumed", robot.assumed},
                           {"period_ms", 1e3 * config_period_s(&chosen.rig.firmware)},
                           {"dead_time_ms", chosen.rig.robot.dead_time_ms},
                           {"force_delay_ms", chosen.rig.sensor.delay_ms},
                           {"states_force_delay", robot.force_delay_ms.has_value()},
                           {"reported_dead_time_ms", nullptr},
                           {"dead_time_band_ms", nullptr},
                           {"lacks_drive_lag", robot.plus_drive_lag && !chosen.rig.has_transfer_behaviour()}};
    if (robot.dead_time_ms) {
        json["reported_dead_time_ms"] = {robot.dead_time_ms->from, robot.dead_time_ms->to};
    }
    if (chosen.dead_time_band) {
        json["dead_time_band_ms"] = {chosen.dead_time_band->from, chosen.dead_time_band->to};
    }
    return json;
}

std::string robot_as_text(const chosen_rig &chosen)
{
    return robot_as_json(chosen).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void check_recorded_robot(const std::string &text, const std::string &path)
{
    try {
        (void)robot_sentence(nlohmann::json::parse(text)); /* has all that it needs */
    } catch (const nlohmann::json::exception &) {
        throw input_error(path + ": is damaged: what it records of the robot preset cannot be read");
    }
}

std::string robot_sentence(const nlohmann::json &robot)
{
    const double dead_time_ms = robot.at("dead_time_ms");
    const nlohmann::json &reported = robot.at("reported_dead_time_ms");
    std::string text = robot.at("preset").get<std::string>() + ": period " + short_number(robot.at("period_ms")) +
                       " ms, dead time " + short_number(dead_time_ms) + " ms";
    if (!robot.at("dead_time_band_ms").is_null()) {
        text += ", the upper end of the reported " + range_text(reported);
    } else if (!reported.is_null() && reported.at(1) != dead_time_ms) {
        text += " (reported: " + range_text(reported) + ")";
    }
    if (robot.at("states_force_delay")) {
        text += "; force delay " + short_number(robot.at("force_delay_ms")) + " ms";
    }
    if (robot.at("lacks_drive_lag")) {
        text += "; without the drive's lag: robot.transfer_frequency_Hz states it";
    }
    return text;
}

} // namespace berth
