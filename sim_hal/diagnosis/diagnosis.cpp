#include "diagnosis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "../../hal/rig/rig_file.h"
#include "../hil/setpoint_step.h"
#include "command_steps.h"
#include "floor.h"
#include "formatted.h"
#include "independent_records.h"
#include "measured_motion.h"
#include "mistaken_signals.h"
#include "moving_push.h"
#include "record_table.h"
#include "robot_and_force.h"
#include "sample_age.h"
#include "shown_by_force.h"
#include "side_records.h"
#include "uneven_noise.h"

namespace berth
{

namespace
{

/* A rig that was given no rate gets the record's. */
void take_rate(rig &rig, record &data)
{
    if (rig.is_rate_given) {
        return;
    }
    rig.firmware.loop.rate_Hz = 1.0 / data.period_s;
    rig.is_rate_given = true;
    const bool shows_robot =
        !data.command_position_m.empty() && !(data.robot_position_m.empty() && data.force_N.empty());
    const bool must_hold = !shows_robot && rig.robot.interpolation == interpolation::linear &&
                           1e-3 * rig.robot.dead_time_ms < data.period_s;
    if (must_hold) {
        rig.robot.interpolation = interpolation::hold;
    }
    char rate[40];
    std::snprintf(rate, sizeof rate, "loop.rate_Hz = %.10g", rig.firmware.loop.rate_Hz);
    if (const auto error = complete_and_check(rig)) {
        throw input_error(data.path + ": the rig file states no loop.rate_Hz, and with the record's, " + rate +
                          ", " + error->key + " " + error->message);
    }
    data.notes.push_back(std::string(rate) + " is the record's: the rig file states none");
    if (must_hold) {
        data.notes.push_back(
            "robot.interpolation = \"hold\": at this rate the robot's dead time is less than a period; "
            "the record does not show the robot");
    }
}

/* The records one after another, as segments of one. */
record read_all(const std::vector<std::string> &paths, rig &rig, std::vector<input_file> &inputs)
{
    record all;
    for (const std::string &path : paths) {
        record next = read_record(path, rig);
        inputs.push_back({"record", path, next.hash, next.content});
        if (all.size() == 0) {
            take_rate(rig, next);
            all = std::move(next);
            continue;
        }
        const std::size_t offset = all.size();
        check_row_count(path + " and those before it", offset + next.size());
        const double shift_s = all.time_s.back() + all.period_s - next.time_s.front();
        for (const auto signal : record_signals) {
            if ((all.*signal).empty() != (next.*signal).empty()) {
                throw input_error(path + ": has not the same signals as " + all.path);
            }
            (all.*signal).insert((all.*signal).end(), (next.*signal).begin(), (next.*signal).end());
        }
        if (!all.filled.empty() || !next.filled.empty()) {
            all.filled.resize(offset, 0);
            next.filled.resize(next.size(), 0);
            all.filled.insert(all.filled.end(), next.filled.begin(), next.filled.end());
        }
        for (const double time_s : next.time_s) {
            all.time_s.push_back(time_s + shift_s);
        }
        for (const record_segment &part : next.segments) {
            all.segments.push_back({part.begin + offset, part.end + offset, part.stands_m});
        }
        all.notes.insert(all.notes.end(), next.notes.begin(), next.notes.end());
        all.is_from_this_firmware = all.is_from_this_firmware && next.is_from_this_firmware;
    }
    return all;
}

/* What a command with too few digits hides. */
void tell_command_steps(diagnosis &result)
{
    constexpr double counts = 0.2; /* of the noise */
    for (const block_diagnosis &block : result.blocks) {
        if (block.command_steps_rms > counts * block.floor.rms) {
            const auto which = static_cast<std::size_t>(block.block);
            result.notes.push_back(formatted("command_position_m is written in steps of %.3g m: ",
                                             command_step_m(result.data, result.given)) +
                                   "that alone leaves " + formatted("%.3g ", block.command_steps_rms) +
                                   std::string(block_units[which]) + " rms of the " +
                                   std::string(block_names[which]) +
                                   " open, and nothing so small is looked for; write it with more digits");
        }
    }
}

/* A force that is scaled wrongly looks like a manipulator of which mass, damping and stiffness are. */
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

verdict overall(const std::vector<block_diagnosis> &blocks)
{
    const auto any = [&](verdict wanted) {
        return std::any_of(blocks.begin(), blocks.end(),
                           [&](const block_diagnosis &block) { return block.verdict == wanted; });
    };
    const bool has_causes = std::any_of(blocks.begin(), blocks.end(),
                                        [](const block_diagnosis &block) { return !block.causes.empty(); });
    if (any(verdict::software_mismatch)) {
        return verdict::software_mismatch;
    }
    if (any(verdict::partly_explained) || (any(verdict::unknown) && has_causes)) {
        return verdict::partly_explained;
    }
    for (const verdict wanted : {verdict::unknown, verdict::one_of, verdict::named}) {
        if (any(wanted)) {
            return wanted;
        }
    }
    return verdict::nothing_detectable;
}

/* The command of this firmware must come out to the last step of the wire: what it computed with is known, not
 * fitted. */
void judge_software(block_diagnosis &result, const rig &rig)
{
    result.extended = rig;
    result.base.clear();
    result.refinable.clear();
    result.doubts.clear();
    const double exact_m = 2.0 * setpoint_step_m(rig.firmware);
    if (result.fit_rms.before > exact_m) {
        result.verdict = verdict::software_mismatch;
    } else {
        result.verdict = verdict::nothing_detectable;
        result.causes.clear();
    }
}

/* What the rig file's delay of the force comes to. */
void tell_sample_age(diagnosis &result, const rig &with_rate)
{
    const double age_ms = result.given.sensor.delay_ms;
    if (with_rate.has_wandering_samples()) {
        result.notes.push_back(formatted("the force is not judged: with sensor.rate_Hz = %.6g ",
                                         with_rate.firmware.sensor_channel.rate_Hz) +
                               formatted("and loop.rate_Hz = %.6g its age changes from tick to tick; give no "
                                         "sensor.rate_Hz, or a multiple, if it was sampled with the loop",
                                         with_rate.firmware.loop.rate_Hz));
    } else if (can_replay(result.data, block::force) && age_ms != with_rate.sensor.delay_ms) {
        result.notes.push_back(
            formatted("the force is %.4g ms old where a tick takes it: ", age_ms) +
            formatted("with sensor.delay_ms = %.4g a sample comes between two ticks, ", with_rate.sensor.delay_ms) +
            "and waits; sensor.sample_phase_ms says when in the tick it is taken");
    }
}

/* What the record would have shown, and what would show more. */
void tell_detectable(diagnosis &result, const sample_events &events, const diagnosis_request &request,
                     bool has_validation)
{
    for (const block_diagnosis &block : result.blocks) {
        if (block.block == block::manipulator && result.data.is_from_this_firmware) {
            continue; /* no physics decides what it does */
        }
        block_model model(block.block, result.data, result.given, events,
                          has_validation ? held_out_parts::none : held_out_parts::two_tenths);
        const auto sizes = find_detectable(model, block.floor, block.fitted, result.given, request.options);
        result.detectable.insert(result.detectable.end(), sizes.begin(), sizes.end());
        if (&block == &result.blocks.back()) {
            result.next = show_more(block, sizes, result.data, result.given);
        }
    }
}

void propose_next(diagnosis &result, const sample_events &events, const diagnosis_request &request,
                  bool has_validation)
{
    if (result.verdict == verdict::nothing_detectable) {
        tell_detectable(result, events, request, has_validation);
        return;
    }
    for (const verdict open : {verdict::partly_explained, verdict::unknown, verdict::one_of}) {
        for (const block_diagnosis &block : result.blocks) {
            if (block.verdict == open && !result.next) {
                result.next = tell_rivals_apart(block, result.data, result.given);
            }
        }
    }
}

} // namespace

std::string_view unit_of(std::string_view key)
{
    for (const std::string_view unit :
         {"N_per_m3", "N_per_m2", "N_s_per_m", "N_per_m", "m_per_s2", "m_per_s", "ms_per_s", "N_per_s", "s_per_m",
          "per_s", "kg", "Hz", "ms", "ppm", "rad", "N", "m"}) {
        if (key.size() > unit.size() && key.substr(key.size() - unit.size()) == unit &&
            key[key.size() - unit.size() - 1] == '_') {
            return unit;
        }
    }
    return "1";
}

diagnosis diagnose(const diagnosis_request &request)
{
    const auto tell = [&](const std::string &what) {
        if (request.progress) {
            request.progress(what);
        }
    };
    diagnosis result;
    tell("reading");
    result.given = request.rig;
    result.data = read_all(request.records, result.given, result.inputs);
    drive_by_measured_motion(result.data);
    const record &data = result.data;
    const rig with_rate = result.given;
    result.given = with_age_as_delay(with_rate);
    refuse_copies(data);
    refuse_mistaken_signals(result.data, result.given);
    std::optional<record> validation;
    std::optional<record> standstill;
    std::optional<record> repetition;
    for (const auto &[role, path, made] : {std::make_tuple("validation", &request.validation, &validation),
                                           std::make_tuple("standstill", &request.standstill, &standstill),
                                           std::make_tuple("repetition", &request.repetition, &repetition)}) {
        if (!path->empty()) {
            *made = read_record(*path, result.given, made == &standstill);
            drive_by_measured_motion(**made);
            result.inputs.push_back({role, *path, (*made)->hash, (*made)->content});
        }
    }
    refuse_same(result.inputs);
    for (const auto &[role, other] :
         {std::make_pair("--validate", &validation), {"--standstill", &standstill}, {"--repeat", &repetition}}) {
        if (*other) {
            refuse_useless(**other, role, data);
        }
    }
    if (!validation) {
        result.notes.push_back("two tenths of the record are held out; a record with another command as --validate "
                               "would be better evidence");
    }
    result.notes.insert(result.notes.end(), data.notes.begin(), data.notes.end());
    tell_sample_age(result, with_rate);

    result.extended = result.given;
    events_of_records events;
    const std::vector<event_finding> repeats = find_repeats(data, result.given, events.fit);
    if (validation) {
        find_repeats(*validation, result.given, events.unseen);
    }
    const auto input_of = [&](block block) {
        diagnosis_input input;
        input.fit = &data;
        input.validation = validation && can_replay(*validation, block) ? &*validation : nullptr;
        if (standstill) {
            input.floor = standstill_floor(*standstill, block);
        } else if (repetition) {
            input.floor = repetition_floor(data, *repetition, block);
        }
        input.options = request.options;
        return input;
    };
    bool any = false;
    block_start before;
    for (const block block : {block::manipulator, block::robot, block::force}) {
        if (!can_replay(data, block) || (block == block::force && with_rate.has_wandering_samples())) {
            continue;
        }
        any = true;
        tell("looking at the " + std::string(block_names[static_cast<int>(block)]));
        diagnosis_input input = input_of(block);
        if (block == block::manipulator && data.is_from_this_firmware) {
            input.effects_max = 0;
        }
        const bool has_robot = !result.blocks.empty() && result.blocks.back().block == block::robot;
        const bool is_behind_robot = block == block::force && has_robot;
        if (is_behind_robot) {
            refine_thresholds(result.blocks.back(), input, events);
            result.extended = result.blocks.back().extended;
            know_robot(input, result.blocks.back(), result.given);
        }
        const block_start start{input, result.extended, events,
                                block == block::force ? repeats : std::vector<event_finding>{}};
        input.may_search_again = block == block::robot;
        block_diagnosis found = diagnose_block(block, input, result.extended, events, start.found_events);
        if (is_behind_robot) {
            ask_force_about_robot(result.blocks.back(), found, events, before, start, result.given);
            let_unseen_force_tell_stand_in(result.blocks.back(), found, events, before, start, result.given);
            explain_robot_beside_shown(result.blocks.back(), found, events, before, start, result.given);
            doubt_reports(result.blocks.back(), found, events, before, start);
            doubt_tolerances(result.blocks.back(), found, result.given);
            doubt_force(result.blocks.back(), found, before, events);
        }
        before = start;
        if (block == block::manipulator && data.is_from_this_firmware) {
            judge_software(found, result.given);
        } else if (block == block::manipulator) {
            found = better_of_held_and_moving(
                std::move(found), result.data, validation,
                [&] { return diagnose_block(block, input, result.extended, events, {}); }, result.notes);
        }
        for (block_diagnosis &earlier : result.blocks) {
            drop_repeated(earlier, found);
            take_refined(earlier, found);
            if (block == block::force && earlier.block == block::robot) {
                judge_robot_again(earlier, found, input_of(earlier.block), events);
                measure_again(earlier, found.extended, input_of(earlier.block), events);
            }
        }
        result.extended = found.extended;
        result.blocks.push_back(std::move(found));
    }
    if (!any) {
        throw input_error(data.path +
                          ": no block can be replayed: a diagnosis needs operator_force_N or "
                          "operator_position_m with command_position_m, or command_position_m with "
                          "robot_position_m or force_N, or robot_position_m with force_N" +
                          (with_rate.has_wandering_samples() ? "; " + result.notes.back() : ""));
    }
    tell_command_steps(result);
    tell_scaled_manipulator(result);
    const std::vector<std::string> uneven = noise_that_follows_motion(result.blocks, data);
    result.notes.insert(result.notes.end(), uneven.begin(), uneven.end());
    result.verdict = overall(result.blocks);
    tell(result.verdict == verdict::nothing_detectable ? "looking for what it would have shown"
                                                       : "looking for the next experiment");
    propose_next(result, events.fit, request, validation.has_value());
    result.extended = with_delay_of_age(result.extended, with_rate);
    result.given = with_rate;
    std::size_t at_fault = 0;
    for (const block_diagnosis &block : result.blocks) {
        if (block.verdict != verdict::nothing_detectable) {
            at_fault++;
            result.located = at_fault == 1 ? std::string(block_names[static_cast<int>(block.block)]) : "";
        }
    }
    return result;
}

} // namespace berth
