/* The stages in which the robot moves: shadow, ramp and run. */
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "../../firmware/compensation/compensation.h"
#include "../../firmware/force_feedback.h"
#include "../../firmware/manipulator.h"
#include "../../hal/rig/rig_file.h"
#include "../stability/compensation_states.h"
#include "gain_limit.h"
#include "judge.h"

namespace berth
{

namespace
{

std::string text_of(const char *format, double value)
{
    char text[160];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

std::int64_t running_ticks(const std::vector<tick_record> &ticks)
{
    return std::count_if(ticks.begin(), ticks.end(),
                         [](const tick_record &tick) { return tick.state == SUPERVISOR_RUNNING; });
}

/* Why a stage in which the loop should run did not; empty: it did. */
std::string stop_words(const stage_run &run)
{
    if (run.ticks.empty() || running_ticks(run.ticks) == 0) {
        return "the loop never ran";
    }
    const run_stop &stop = run.motion.stop;
    return stop.is_early() ? std::string("the loop was stopped: ") + stop_cause_name(stop.cause) : std::string();
}

stage_entry moving_entry(stage stage, bool passes, const std::string &because)
{
    stage_entry entry;
    entry.stage = stage;
    entry.outcome = passes ? stage_outcome::passed : stage_outcome::failed;
    entry.because = because;
    return entry;
}

void add_promise(stage_entry &entry, const loop_promise &measured, const loop_promise &assumed)
{
    if (measured.damping_ratio) {
        entry.values.push_back(
            {"predicted damping ratio at full feedback", "1", *measured.damping_ratio, assumed.damping_ratio, {}});
    }
    if (measured.growth_per_s) {
        entry.values.push_back(
            {"predicted growth at full feedback", "1/s", *measured.growth_per_s, assumed.growth_per_s, {}});
    }
    if (measured.gain_limit) {
        entry.values.push_back({"feedback at which the margin is used up", "1", *measured.gain_limit, 1.0, {}});
    }
}

} // namespace

loop_promise promise_of(const rig &rig, double margin)
{
    loop_promise made;
    try {
        made.damping_ratio = least_damping_ratio(rig);
        made.growth_per_s = predict_growth(rig).growth_per_s;
        if (compensation_is_on(&rig.firmware) == 0) {
            made.gain_limit =
                gain_limit([&](double gain) { return least_damping_ratio(with_feedback_gain(rig, gain)); }, margin);
        }
    } catch (const input_error &error) {
        made.why_not = error.what();
    }
    return made;
}

double shadow_deviation_m(const rig &told, const std::vector<tick_record> &ticks)
{
    const auto shadow = std::make_unique<manipulator>();
    manipulator_start(shadow.get(), &told.firmware);
    double largest_m = 0.0;
    bool runs = false;
    for (const tick_record &tick : ticks) {
        if (tick.state != SUPERVISOR_RUNNING) {
            runs = false;
            continue;
        }
        if (!runs) {
            manipulator_rest_at(shadow.get(), tick.manipulator_position_m);
            runs = true;
        }
        largest_m = std::max(largest_m, std::abs(shadow->position_m - tick.manipulator_position_m));
        const operator_command command{tick.operator_position_m, tick.operator_velocity_m_per_s,
                                       tick.operator_force_N, 0};
        manipulator_step(shadow.get(), &command, tick.force_N);
    }
    return largest_m;
}

stage_entry judge_shadow(const rig &told, const stage_run &run, const loop_promise &measured,
                         const loop_promise &assumed, double margin)
{
    std::string trouble = stop_words(run);
    if (trouble.empty() && !measured.damping_ratio) {
        trouble = "the damping of the loop cannot be predicted: " + measured.why_not;
    } else if (trouble.empty() && *measured.damping_ratio < margin) {
        trouble = text_of("at full feedback the predicted damping ratio is %.3g, ", *measured.damping_ratio) +
                  text_of("less than the margin of %.3g", margin);
    }
    stage_entry entry =
        moving_entry(stage::shadow, trouble.empty(),
                     trouble.empty() ? "the loop is predicted to be damped at full feedback" : trouble);
    if (told.firmware.arm.kind == ARM_NONE) {
        entry.values.push_back(
            {"motion that the force would have made", "mm", 1e3 * shadow_deviation_m(told, run.ticks), {}, {}});
    }
    entry.values.push_back({"largest force", "N", std::abs(run.motion.measured_peak.force_N), {}, {}});
    add_promise(entry, measured, assumed);
    if (measured.gain_limit) {
        entry.proposed.emplace_back("feedback.gain", *measured.gain_limit);
    }
    return entry;
}

stage_entry judge_ramp(const rig &told, const stage_run &run, double margin)
{
    const double gain = force_feedback_gain(&told.firmware, running_ticks(run.ticks));
    std::string trouble = stop_words(run);
    if (!trouble.empty()) {
        trouble += text_of(", at a feedback of %.3f", gain);
    } else if (gain < 1.0) {
        trouble = text_of("the ramp ends at a feedback of %.3f: ", gain) +
                  text_of("beyond it the predicted damping ratio is less than %.3g", margin);
    }
    stage_entry entry =
        moving_entry(stage::ramp, trouble.empty(), trouble.empty() ? "full feedback is reached" : trouble);
    entry.values = {{"feedback reached", "1", gain, 1.0, {}},
                    {"largest force", "N", std::abs(run.motion.measured_peak.force_N), {}, {}}};
    return entry;
}

stage_entry judge_run(const stage_run &run, const run_answer &answer, const loop_promise &measured)
{
    std::string trouble = stop_words(run);
    const stability_verdict &verdict = answer.verdict;
    if (trouble.empty() && verdict.is_stable != std::optional<bool>(true)) {
        trouble = std::string("the verdict is ") + verdict_name(verdict.kind) + ": " + verdict.because;
    }
    stage_entry entry = moving_entry(stage::run, trouble.empty(), trouble.empty() ? "the loop is stable" : trouble);
    if (verdict.growth) {
        entry.values.push_back(
            {"growth", "1/s", verdict.growth->growth_per_s, measured.growth_per_s, verdict.growth->ci95_per_s});
    }
    entry.values.push_back({"largest force", "N", std::abs(run.motion.measured_peak.force_N), {}, {}});
    return entry;
}

} // namespace berth
