#include "run_result.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "../../hal/rig/rig_file.h"
#include "../arm/linear_arm.h"
#include "../stability/inverse_filter_response.h"
#include "../start_trial.h"
#include "robot_choice.h"
#include "verdict_report.h"

namespace berth
{

namespace
{

bool has_arm(const rig &rig)
{
    return rig.firmware.arm.kind != ARM_NONE;
}

bool is_drive(const rig &rig)
{
    return rig.firmware.robot_channel.profile == ROBOT_PROFILE_CIA402;
}

/* State and trouble of the drive in the last tick. */
std::string drive_text(const run_result &result)
{
    char text[CIA402_TEXT_BYTES_MAX];
    std::snprintf(text, sizeof text, "%s, statusword 0x%04X",
                  cia402_state_name(cia402_state_of(result.drive_statusword)), result.drive_statusword);
    std::string all = text;
    cia402_trouble_text(result.drive_trouble, result.drive_setup_step, result.drive_error, text);
    return text[0] == '\0' ? all : all + "; " + text;
}

void print_limits(const run_result &result)
{
    std::string acted;
    for (int i = 0; i < LIMIT_COUNT; i++) {
        if (result.limit_ticks[i] > 0) {
            acted += (acted.empty() ? "" : ", ") + std::string(limit_names[i]) + " in " +
                     std::to_string(result.limit_ticks[i]) + " ticks";
        }
    }
    std::printf("  %-14s %s\n", "limits", acted.empty() ? "never acted" : ("acted: " + acted).c_str());
}

/* Where a sample is more than one frame a tick. */
void print_force_samples(const run_result &result, const rig &rig)
{
    if (rig.firmware.sensor_channel.layout == SENSOR_ONE_FRAME && rig.sensor.rate_Hz == 0.0) {
        return;
    }
    const bool is_numbered = sensor_layout_is_numbered(&sensor_layouts[rig.firmware.sensor_channel.layout]);
    std::printf("  %-14s %u samples, ", "force", result.force_samples);
    if (is_numbered) {
        std::printf("%u torn ones rejected", result.torn_samples);
    } else {
        std::printf("%u rejected as suspected torn (frames without a number)", result.suspected_torn_samples);
    }
    if (result.running_ticks > 0) {
        std::printf("; arrived %.3f to %.3f ms before their use",
                    1e-6 * static_cast<double>(result.force_age_min_ns),
                    1e-6 * static_cast<double>(result.force_age_max_ns));
    }
    std::printf("\n");
}

void print_transfer_behaviour(const rig &rig)
{
    if (!rig.has_transfer_behaviour()) {
        return;
    }
    const inverse_filter_response response = respond(rig);
    std::printf("  %-14s amplitude error up to 5 Hz: %.3f %%", "robot", 100.0 * response.amplitude_error_without);
    if (rig.firmware.inverse_filter.enabled) {
        std::printf(", with inverse filter %.3f %%; its price: noise x %.2f, phase %+.2f deg at 5 Hz",
                    100.0 * response.amplitude_error_with, response.noise_gain, response.phase_deg);
    }
    std::printf("\n");
}

nlohmann::json accuracy_json(const step_accuracy &accuracy, const rig &rig)
{
    const bool is_finite = accuracy.tool_m && std::isfinite(*accuracy.tool_m); /* JSON has no infinity */
    const std::optional<bool> is_accurate = accuracy.is_accurate();
    return {{"accurate", is_accurate ? nlohmann::json(*is_accurate) : nlohmann::json()},
            {"tool_m", is_finite ? nlohmann::json(*accuracy.tool_m) : nlohmann::json()},
            {"repeatability_m", usual_repeatability_m},
            {"step_ms", accuracy.step_ms},
            {"because", accuracy_sentence(accuracy, rig)}};
}

} // namespace

void note_tick(run_result &result, const rig &rig, const tick_record &record, const arm_record &arm,
               std::optional<double> spring_force_N)
{
    result.motion.note_tick(record, arm.motors_at_limit != 0, spring_force_N);
    result.ticks++;
    result.overruns += record.missed_ticks;
    for (int i = 0; i < LIMIT_COUNT && record.limits >> i; i++) {
        result.limit_ticks[i] += (record.limits >> i) & 1;
    }
    if (record.state != SUPERVISOR_RUNNING) {
        return;
    }
    result.running_ticks++;
    result.force_age_min_ns = std::min(result.force_age_min_ns, record.force_frame_age_ns);
    result.force_age_max_ns = std::max(result.force_age_max_ns, record.force_frame_age_ns);
    result.energy.note_tick(record);
    result.guidance.note_tick(record.index, arm);
    result.motors.note_tick(record.index, arm);
    result.wheel.note_tick(record.index, arm, rig.firmware.arm.attitude);
}

void conclude(run_result &result, const rig &rig, const tick_record &last, answer_scope scope)
{
    result.simulated_s =
        result.ticks > 0 ? config_period_s(&rig.firmware) * static_cast<double>(last.index + 1) : 0.0;
    result.state = static_cast<supervisor_state>(last.state);
    result.cause = static_cast<stop_cause>(last.stop_cause);
    result.frames_rejected = last.rejected_frames;
    result.frames_lost = last.lost_frames;
    result.error_frames = last.error_frames;
    result.saturated_setpoints = last.saturated_setpoints;
    result.force_samples = last.force_samples;
    const bool is_numbered = sensor_layout_is_numbered(&sensor_layouts[rig.firmware.sensor_channel.layout]);
    (is_numbered ? result.torn_samples : result.suspected_torn_samples) = last.torn_samples;
    result.drive_statusword = last.drive_statusword;
    result.drive_trouble = static_cast<cia402_trouble>(last.drive_trouble);
    result.drive_error = last.drive_error;
    result.drive_setup_step = last.drive_setup_step;
    result.energy.has_arm = has_arm(rig);
    if (result.running_ticks == 0) {
        result.obstacles = obstacles_of(rig, last);
    }
    result.evidence = result.motion.conclude();
    const run_answer answer = answer_of_run(rig, result.evidence, result.obstacles, scope);
    result.predicted = answer.predicted;
    result.margin = answer.margin;
    result.verdict = answer.verdict;
    if (has_arm(rig) && scope == answer_scope::whole) {
        result.accuracy = estimate_accuracy(rig);
    }
}

void print_summary(const run_result &result, const rig &rig)
{
    std::printf("%s: %s\n", rig.name.c_str(), rig.description.c_str());
    if (const nlohmann::json robot = nlohmann::json::parse(result.robot); !robot.is_null()) {
        std::printf("  %-14s %s\n", "robot", robot_sentence(robot).c_str());
    }
    print_assumptions(rig);
    print_verdict(result.verdict);
    if (result.accuracy) {
        std::printf("  %-14s %s\n", "accuracy", accuracy_sentence(*result.accuracy, rig).c_str());
    }
    for (const std::string &line : attitude_left_out(rig.firmware.arm)) {
        std::printf("  %-14s %s\n", "", line.c_str());
    }
    print_margin(result.margin);
    print_delay_budget(rig);
    result.energy.print();
    print_peaks(result.evidence);
    std::printf("  %-14s %lld at %g Hz = %.2f s, %lld overruns\n", "ticks", static_cast<long long>(result.ticks),
                rig.firmware.loop.rate_Hz, result.simulated_s, static_cast<long long>(result.overruns));
    std::printf("  %-14s %s%s%s\n", "supervisor", supervisor_state_name(result.state),
                result.cause != STOP_NONE ? ", because: " : "",
                result.cause != STOP_NONE ? stop_cause_name(result.cause) : "");
    print_limits(result);
    if (has_arm(rig)) {
        result.guidance.print(config_period_s(&rig.firmware));
        result.motors.print(config_period_s(&rig.firmware));
        result.wheel.print(config_period_s(&rig.firmware), rig.firmware.arm.attitude);
    }
    if (!result.predicted.growth_per_s) {
        std::printf("  %-14s %s\n", "not predicted", result.predicted.why_not.c_str());
    }
    std::printf("  %-14s %lld taken, %u rejected, %u lost, %u error frames, %u setpoints saturated\n", "frames",
                static_cast<long long>(result.frames_accepted), result.frames_rejected, result.frames_lost,
                result.error_frames, result.saturated_setpoints);
    print_force_samples(result, rig);
    if (is_drive(rig)) {
        std::printf("  %-14s %s\n", "drive", drive_text(result).c_str());
    }
    print_transfer_behaviour(rig);
    if (result.wall_s > 0.0) {
        std::printf("  %-14s %.0f times real time (%.1f ms)\n", "speed", result.simulated_s / result.wall_s,
                    1e3 * result.wall_s);
    }
    if (!result.log.empty()) {
        std::printf("  %-14s %s\n", "log", result.log.c_str());
    }
    for (const std::string &path : result.candumps) {
        std::printf("  %-14s %s\n", "", path.c_str());
    }
    if (!result.runs_page.empty()) {
        std::printf("  %-14s %s\n", "all runs", result.runs_page.c_str());
    }
    std::printf("  %-14s %s, berth %s\n", "configuration", config_hash(rig).c_str(), result.version.c_str());
}

nlohmann::json as_json(const run_result &result, const rig &rig)
{
    nlohmann::json limits;
    for (int i = 0; i < LIMIT_COUNT; i++) {
        limits[limit_names[i]] = result.limit_ticks[i];
    }
    nlohmann::json json = {
        {"rig", rig.name},
        {"robot", nlohmann::json::parse(result.robot)},
        {"stopped", stop_json(result.verdict.stop)},
        {"bounces", bounces_json(result.verdict.bounces)},
        {"tracking", tracking_json(result.evidence)},
        {"peak_force", peaks_json(result.evidence)},
        {"gripped", result.was_gripped()},
        {"growth_per_s", nullptr},
        {"growth_ci95_per_s", nullptr},
        {"frequency_Hz", nullptr},
        {"prediction_left_out", nullptr},
        {"why_not_predicted", nullptr},
        {"ticks", result.ticks},
        {"overruns", result.overruns},
        {"peak_force_N", result.evidence.measured_peak.force_N},
        {"simulated_s", result.simulated_s},
        {"state", supervisor_state_name(result.state)},
        {"stop_cause", stop_cause_name(result.cause)},
        {"limit_ticks", limits},
        {"accuracy", nullptr},
        {"guidance", nullptr},
        {"motors", nullptr},
        {"wheel", nullptr},
        {"frames_accepted", result.frames_accepted},
        {"frames_rejected", result.frames_rejected},
        {"frames_lost", result.frames_lost},
        {"error_frames", result.error_frames},
        {"saturated_setpoints", result.saturated_setpoints},
        {"force_samples", result.force_samples},
        {"torn_samples", result.torn_samples},
        {"suspected_torn_samples", result.suspected_torn_samples},
        {"log", nullptr},
        {"config_hash", config_hash(rig)},
        {"version", result.version},
    };
    json.update(answer_json(rig, result.verdict, result.margin));
    json["prediction"] = prediction_json(result.predicted);
    if (result.accuracy) {
        json["accuracy"] = accuracy_json(*result.accuracy, rig);
    }
    if (has_arm(rig)) {
        json["guidance"] = result.guidance.as_json(config_period_s(&rig.firmware));
        json["motors"] = result.motors.as_json(config_period_s(&rig.firmware), rig.firmware.arm.joint_count);
        json["wheel"] = result.wheel.as_json(config_period_s(&rig.firmware), rig.firmware.arm.attitude);
    }
    const bool is_of_swing = result.verdict.kind != verdict_kind::limit_cycle; /* else of its rise, or of nothing */
    if (result.evidence.growth && is_of_swing) {
        json["growth_per_s"] = result.evidence.growth->growth_per_s;
        json["growth_ci95_per_s"] = result.evidence.growth->growth_ci95_per_s;
        json["frequency_Hz"] = result.evidence.growth->frequency_Hz;
    }
    if (result.verdict.kind == verdict_kind::limit_cycle && result.evidence.swing_Hz > 0.0) {
        json["frequency_Hz"] = result.evidence.swing_Hz; /* of the cycle, limits included */
    }
    if (result.predicted.growth_per_s) {
        json["prediction_left_out"] = attitude_left_out(rig.firmware.arm);
    } else {
        json["why_not_predicted"] = result.predicted.why_not;
    }
    if (result.wall_s > 0.0) {
        json["speed_x_realtime"] = result.simulated_s / result.wall_s;
        json["dropped_records"] = result.dropped_records;
    }
    if (result.running_ticks > 0) {
        json["energy"] = result.energy.as_json();
    }
    if (!result.log.empty()) {
        json["log"] = result.log;
    }
    if (is_drive(rig)) {
        json["drive"] = {{"state", cia402_state_name(cia402_state_of(result.drive_statusword))},
                         {"statusword", result.drive_statusword},
                         {"trouble", cia402_trouble_name(result.drive_trouble)},
                         {"error_code", result.drive_error},
                         {"setup_object", cia402_setup_object(result.drive_setup_step)}};
    }
    if (rig.has_transfer_behaviour()) {
        const inverse_filter_response response = respond(rig);
        json["inverse_filter"] = {{"enabled", rig.firmware.inverse_filter.enabled != 0},
                                  {"amplitude_error_without", response.amplitude_error_without},
                                  {"amplitude_error_with", response.amplitude_error_with},
                                  {"phase_deg", response.phase_deg},
                                  {"noise_gain", response.noise_gain}};
    }
    return json;
}

} // namespace berth
