#include "commission.h"

#include <cmath>

#include "../../hal/rig/keys.h"
#include "../../hal/rig/rig_file.h"
#include "../log/ulog_reader.h"
#include "gain_limit.h"
#include "step_stage.h"

namespace berth
{

namespace
{

std::vector<std::string> joined(std::vector<std::string> first, const std::vector<std::string> &second)
{
    first.insert(first.end(), second.begin(), second.end());
    return first;
}

/* Sections of the hardware. The firmware knows of them what the rig file states, and nothing more. */
void refuse_firmware_keys(const std::vector<std::string> &overrides)
{
    static const std::string sections[] = {"robot.", "sensor.", "object.", "bus.", "tool.", "run."};
    for (const std::string &override : overrides) {
        bool is_hardware = false;
        for (const std::string &section : sections) {
            is_hardware = is_hardware || override.rfind(section, 0) == 0;
        }
        if (!is_hardware) {
            throw input_error(
                "--hardware " + override +
                ": is nothing of the hardware, which has the sections robot, sensor, object, bus, tool "
                "and run; use --set for all others");
        }
    }
}

/* Of a simulated sensor without any, in the stage step. */
constexpr const char *least_noise = "sensor.noise_N=0.01";

std::array<double, 3> of_length(const std::array<double, 3> &direction, const std::array<double, 3> &like)
{
    const double wanted = std::hypot(like[0], like[1], like[2]);
    const double length = std::hypot(direction[0], direction[1], direction[2]);
    return {wanted / length * direction[0], wanted / length * direction[1], wanted / length * direction[2]};
}

/* A log of another stage, or of another rig, says nothing about this one. */
void refuse_other_logs(const stage_request &request, const rig &told)
{
    for (const std::string &log : request.logs) {
        if (stage_configuration(ulog_reader(log).recorded_rig()) != stage_configuration(told)) {
            throw input_error(
                log + ": was not made in stage " + name_of(request.stage) +
                " of this rig and this record; give the same rig, --set and --ramp-s as on the target");
        }
    }
}

/* `index`: of several poses. */
stage_run run_of(const stage_request &request, const stage_rigs &rigs, std::size_t index = 0)
{
    if (!request.logs.empty()) {
        return read_stage(request.logs[index]);
    }
    return play_stage(rigs.told, rigs.hardware, stage_log(request));
}

std::vector<tare_pose> tare_poses(const stage_request &request, const stage_rigs &rigs)
{
    if (!request.logs.empty() && request.logs.size() != std::max<std::size_t>(request.poses.size(), 1)) {
        throw input_error("--log: give one log for each --pose, in the same order");
    }
    std::vector<tare_pose> poses;
    if (request.poses.empty()) {
        poses.push_back({rigs.told.tool.gravity_m_per_s2, run_of(request, rigs)});
    }
    for (std::size_t i = 0; i < request.poses.size(); i++) {
        stage_rigs posed = rigs;
        const auto gravity = of_length(request.poses[i], rigs.told.tool.gravity_m_per_s2);
        posed.hardware.tool.gravity_m_per_s2 = gravity;
        poses.push_back({gravity, run_of(request, posed, i)});
    }
    return poses;
}

} // namespace

std::string stage_log(const stage_request &request)
{
    return request.folder + "/" + name_of(request.stage) + ".ulg";
}

stage_entry commission_stage(const stage_request &request, const commissioning &record)
{
    refuse_firmware_keys(request.hardware);
    const std::vector<std::string> measured = measured_overrides(record, request.stage);
    const rig given = request.load({});
    const rig believed = request.load(measured);
    stage_settings settings = request.settings;
    loop_promise promise;
    const bool is_run = request.stage == stage::run;
    if (request.stage >= stage::shadow) {
        promise =
            promise_of(with_feedback_gain(believed, is_run ? believed.firmware.feedback.gain : 1.0), request.margin);
    }
    if (request.stage == stage::ramp) {
        settings.gain_max = promise.gain_limit.value_or(1.0);
    }
    const std::vector<std::string> changes = stage_overrides(request.stage, believed, settings);
    std::vector<std::string> hardware = request.hardware;
    if (request.stage == stage::step && request.load(hardware).sensor.noise_N == 0.0) {
        hardware.push_back(least_noise); /* the diagnosis refuses a column that never changes */
    }
    const stage_rigs rigs{given, request.load(joined(measured, changes)), request.load(joined(hardware, changes))};
    refuse_other_logs(request, rigs.told);
    stage_entry entry;
    switch (request.stage) {
    case stage::watch:
        entry = judge_watch(rigs.told, run_of(request, rigs));
        break;
    case stage::tare:
        entry = judge_tare(given, tare_poses(request, rigs));
        break;
    case stage::step:
        entry = judge_step(request, rigs, run_of(request, rigs));
        break;
    case stage::shadow:
        entry = judge_shadow(rigs.told, run_of(request, rigs), promise, promise_of(given, request.margin),
                             request.margin);
        break;
    case stage::ramp:
        entry = judge_ramp(rigs.told, run_of(request, rigs), request.margin);
        break;
    case stage::run: {
        const stage_run run = run_of(request, rigs);
        entry = judge_run(run,
                          answer_of_run(with_feedback_gain(believed, believed.firmware.feedback.gain), run.motion,
                                        {}, answer_scope::verdict_alone),
                          promise);
        break;
    }
    }
    entry.log = request.logs.empty() ? stage_log(request) : request.logs.front();
    return entry;
}

} // namespace berth
