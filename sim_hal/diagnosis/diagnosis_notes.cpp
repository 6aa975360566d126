#include "diagnosis_notes.h"

#include <algorithm>
#include <cmath>

#include "fit/base.h"
#include "formatted.h"
#include "record/command_steps.h"
#include "record/motion_noise.h"
#include "record/record_columns.h"
#include "record/written_digits.h"

namespace berth
{

void tell_sample_age(diagnosis &result, const rig &given)
{
    const double age_ms = result.given.sensor.delay_ms;
    if (given.has_wandering_samples()) {
        result.notes.push_back(formatted("the force is not judged: with sensor.rate_Hz = %.6g ",
                                         given.firmware.sensor_channel.rate_Hz) +
                               formatted("and loop.rate_Hz = %.6g its age changes from tick to tick; give no "
                                         "sensor.rate_Hz, or a multiple, if it was sampled with the loop",
                                         given.firmware.loop.rate_Hz));
    } else if (can_replay(result.data, block::force) && age_ms != given.sensor.delay_ms) {
        result.notes.push_back(
            formatted("the force is %.4g ms old where a tick takes it: ", age_ms) +
            formatted("with sensor.delay_ms = %.4g a sample comes between two ticks, ", given.sensor.delay_ms) +
            "and waits; sensor.sample_phase_ms says when in the tick it is taken");
    }
}

void tell_tolerances_without_use(diagnosis &result, const rig &given)
{
    for (const std::string_view key : tolerances_without_use(given)) {
        result.notes.push_back("the tolerance of " + std::string(key) +
                               " is not used: a diagnosis has nothing of this name to re-tune");
    }
}

void tell_input_steps(diagnosis &result)
{
    for (const block_diagnosis &block : result.blocks) {
        if (is_open_by_input_steps(block)) {
            const auto which = static_cast<std::size_t>(block.block);
            const std::string few = columns_with_few_digits(result.data);
            if (block.block == block::manipulator && few.empty()) {
                continue; /* nothing that more digits would better */
            }
            const std::string written = block.block == block::manipulator
                                            ? "written are " + few + ": "
                                            : formatted("command_position_m is written in steps of %.3g m: ",
                                                        command_step_m(result.data, result.given));
            result.notes.push_back(written + "that alone leaves " + formatted("%.3g ", block.input_steps_rms) +
                                   std::string(block_units[which]) + " rms of the " +
                                   std::string(block_names[which]) +
                                   " open, and nothing so small is looked for; write it with more digits");
        }
    }
}

void tell_motion_noise(diagnosis &result, const sample_events &events)
{
    constexpr double counts = 0.2; /* of the noise */
    for (const block_diagnosis &block : result.blocks) {
        const double force_N =
            block.block == block::force ? force_of_motion_noise_N(result.data, block.extended, events) : 0.0;
        if (force_N > counts * block.floor.rms) {
            result.notes.push_back(
                formatted("robot_position_m has noise of %.2g m from row to row: ", motion_noise_m(result.data)) +
                formatted("it drives the force, and is %.3g N rms of ", force_N) +
                formatted("the %.3g N that are left; what shows beside so much may be that noise; record "
                          "command_position_m, or measure the position more finely",
                          block.fit_rms.after));
        }
    }
}

void tell_scaled_manipulator(diagnosis &result)
{
    constexpr double alike = 1e-3;
    for (const block_diagnosis &block : result.blocks) {
        const bool is_named = std::any_of(block.causes.begin(), block.causes.end(), [](const cause &known) {
            return known.effect->name == "manipulator.parameters";
        });
        const manipulator_config &found = block.extended.firmware.manipulator;
        const manipulator_config &given = result.given.firmware.manipulator;
        const double scale = found.mass_kg / given.mass_kg;
        const auto is_scaled = [&](double now, double before) {
            return std::abs(now - scale * before) < alike * scale * before;
        };
        if (is_named && std::abs(scale - 1.0) > alike &&
            is_scaled(found.damping_N_s_per_m, given.damping_N_s_per_m) &&
            is_scaled(found.stiffness_N_per_m, given.stiffness_N_per_m)) {
            result.notes.push_back(
                formatted(
                    "mass, damping and stiffness of the manipulator are all %.4g times those of the rig file: ",
                    scale) +
                formatted("forces that are all %.4g times too small look the same on any record; compare ", scale) +
                "operator_force_N and force_N with a known weight");
        }
    }
}

void tell_other_zero_of_force(diagnosis &result)
{
    constexpr double alike = 0.02;
    const auto found_in = [&](block which, std::string_view effect, const char *key) {
        for (const block_diagnosis &block : result.blocks) {
            const bool is_named = std::any_of(block.causes.begin(), block.causes.end(),
                                              [&](const cause &known) { return known.effect->name == effect; });
            if (block.block == which && is_named) {
                return value_of(block.extended, key) - value_of(result.given, key);
            }
        }
        return 0.0;
    };
    const double bias_N = found_in(block::force, "sensor.bias", "sensor.bias_N");
    const double lacked_N =
        found_in(block::manipulator, "manipulator.gravity_offset", "manipulator.gravity_offset_N");
    if (result.data.header_line == 0 || bias_N == 0.0 || std::abs(bias_N + lacked_N) > alike * std::abs(bias_N)) {
        return;
    }
    signal_source source = source_of(result.given, "force_N");
    source.offset -= bias_N;
    result.notes.push_back(formatted("force_N has %.4g N more than the sensor gives, and the manipulator did not "
                                     "feel them: a sensor's bias it would; ",
                                     bias_N) +
                           "if the log counts from another zero than the firmware, say in the rig file " +
                           mapping_of(source));
}

void tell_delay_of_rows(diagnosis &result)
{
    constexpr double alike = 0.02;  /* of a row */
    constexpr double coarse = 0.35; /* any number is near a whole one then */
    struct delay {
        std::string_view effect;
        const char *key;
        const char *signal;
        const char *rule;
    };
    constexpr delay delays[] = {
        {"sensor.delay", "sensor.delay_ms", "force_N", "a row has the newest force that had arrived at its time"},
        {"robot.dead_time", "robot.dead_time_ms", "robot_position_m",
         "a row has where the robot was at its time, not what had arrived"}};
    const double row_ms = 1e3 * result.data.period_s;
    for (const block_diagnosis &block : result.blocks) {
        for (const delay &one : delays) {
            const auto known = std::find_if(block.causes.begin(), block.causes.end(),
                                            [&](const cause &each) { return each.effect->name == one.effect; });
            if (known == block.causes.end() || known->parameters.empty()) {
                continue;
            }
            const parameter_estimate &told = known->parameters[0];
            const double rows = (told.value - value_of(result.given, one.key)) / row_ms;
            const double whole = std::round(rows);
            const double uncertain = std::max(alike, told.ci95 / row_ms);
            if (whole != 0.0 && uncertain < coarse && std::abs(rows - whole) < uncertain) {
                result.notes.push_back(std::string(one.key) +
                                       formatted(" is wrong by a whole number of rows, %.0f. A column ", whole) +
                                       one.signal + " that is written late looks the same: " + one.rule);
            }
        }
    }
}

void tell_not_tried(diagnosis &result, const work_limit &limit)
{
    result.not_tried.assign(limit.left_out().begin(), limit.left_out().end());
    if (result.not_tried.empty()) {
        return;
    }
    std::string names;
    for (const std::string &name : result.not_tried) {
        names += (names.empty() ? "" : ", ") + name;
    }
    result.notes.push_back(formatted("the limit of %.3g s of processor time was over", limit.processor_s()) +
                           formatted("; --time-limit %.3g goes on", 4.0 * limit.processor_s()) +
                           "; not tried, or not beside what was found: " + names);
}

} // namespace berth
