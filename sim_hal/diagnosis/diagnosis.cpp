#include "diagnosis.h"

#include <algorithm>
#include <array>

#include "../../hal/rig/rig_file.h"
#include "../hil/setpoint_step.h"
#include "described.h"
#include "diagnosis_notes.h"
#include "fit/base.h"
#include "formatted.h"
#include "late_columns.h"
#include "noise/uneven_noise.h"
#include "record/request_records.h"
#include "record/sample_age.h"
#include "record/side_records.h"
#include "replay/moving_push.h"
#include "search/as_given.h"
#include "search/robot_and_force.h"
#include "search/shown_by_force.h"
#include "search/single_sample_causes.h"

namespace berth
{

namespace
{

void tell(const diagnosis_request &request, const std::string &what)
{
    if (request.progress) {
        request.progress(what);
    }
}

std::string looking_at(block which)
{
    return "looking at the " + std::string(block_names[static_cast<int>(which)]);
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
            if (block.verdict == open && !(result.next && result.next->proposed)) {
                const next_experiment next = tell_rivals_apart(block, result.data, result.given);
                result.next = next.proposed || !result.next ? next : result.next;
            }
        }
    }
}

/* The blocks in the order in which signals run: behind what one is found to do, the next one is replayed. */
class blocks_in_turn
{
  public:
    blocks_in_turn(const diagnosis_request &request, const std::shared_ptr<work_limit> &limit,
                   records_of_request &records, diagnosis &result)
        : request_(request), limit_(limit), records_(records), result_(result),
          repeats_(find_repeats(result.data, result.given, events_.fit))
    {
        if (records_.validation) {
            find_repeats(*records_.validation, result_.given, events_.unseen);
        }
    }

    void look_at(block which)
    {
        diagnosis_input input = input_of(which);
        if (is_computed_here(which)) {
            input.effects_max = 0;
        }
        if (is_behind_robot(which)) {
            refine_thresholds(robot(), input, events_);
            result_.extended = robot().extended;
            know_robot(input, robot(), result_.given);
        }
        const std::optional<noise_model> told_floor = input.floor;
        const std::size_t left_out_before = limit_->left_out().size();
        block_start start{input, result_.extended, events_,
                          which == block::force ? repeats_ : std::vector<event_finding>{}};
        input.may_search_again = which == block::robot;
        block_diagnosis found = diagnose_block(which, input, result_.extended, events_, start.found_events);
        if (found.floor_is_measured && is_refuted(*told_floor, found)) {
            has_no_floor_[static_cast<std::size_t>(which)] = true;
            input.floor = start.input.floor = {};
            events_ = start.events;
            found = diagnose_block(which, input, result_.extended, events_, start.found_events);
        }
        if (is_behind_robot(which)) {
            settle_robot_and_force(found, start);
        }
        before_ = start;
        if (is_computed_here(which)) {
            judge_software(found, result_.given);
        } else if (which == block::manipulator) {
            found = better_of_held_and_moving(
                std::move(found), result_.data, records_.validation,
                {[&] { return diagnose_block(which, input, result_.extended, events_, {}); },
                 [&](const block_diagnosis &known) { return cost_refitted(known); }},
                result_.notes);
        }
        tell_unused_floor(told_floor, found);
        tell_earlier(found);
        doubt_what_was_cut(found, left_out_before);
        result_.extended = found.extended;
        result_.blocks.push_back(std::move(found));
    }

    const sample_events &events() const { return events_.fit; }

  private:
    /* The error that is left is below it: what a robot that switches does in two runs differs by more than noise. Of
     * a standstill it is noise all the same: a sensor that saturates has less of it. */
    bool is_refuted(const noise_model &floor, const block_diagnosis &found) const
    {
        constexpr double clearly = 1.25;
        return !records_.standstill && floor.rms > clearly * found.fit_rms.after;
    }

    /* No physics decides what this firmware computed. */
    bool is_computed_here(block which) const
    {
        return which == block::manipulator && result_.data.is_from_this_firmware;
    }

    bool is_behind_robot(block which) const
    {
        return which == block::force && !result_.blocks.empty() && result_.blocks.back().block == block::robot;
    }

    block_diagnosis &robot() { return result_.blocks.back(); }

    diagnosis_input input_of(block which) const
    {
        diagnosis_input input;
        input.fit = &result_.data;
        input.validation =
            records_.validation && can_replay(*records_.validation, which) ? &*records_.validation : nullptr;
        if (records_.standstill) {
            input.floor = standstill_floor(*records_.standstill, which);
        } else if (records_.repetition && !has_no_floor_[static_cast<std::size_t>(which)]) {
            input.floor = repetition_floor(result_.data, *records_.repetition, which, result_.extended);
            input.floor_is_of_replays = !go_the_same_way(result_.data, *records_.repetition, which);
        }
        input.options = request_.options;
        input.options.limit = limit_;
        input.options.tell = [this, which](const effect &tried) {
            tell(request_, looking_at(which) + ": " + std::string(tried.name));
        };
        return input;
    }

    /* Of a record that was given for it. */
    void tell_unused_floor(const std::optional<noise_model> &told, const block_diagnosis &found)
    {
        const bool is_given = records_.standstill || records_.repetition;
        if (!is_given || found.floor_is_measured || is_computed_here(found.block)) {
            return;
        }
        const auto which = static_cast<int>(found.block);
        const std::string unit(block_units[which]);
        if (told && std::abs(told->rms - found.floor.rms) < 0.01 * found.floor.rms) {
            return; /* the same is told */
        }
        const bool lacks_columns =
            !records_.standstill && !have_same_columns(result_.data, *records_.repetition, found.block);
        result_.notes.push_back(std::string(records_.standstill ? "--standstill" : "--repeat") +
                                " does not tell the noise of the " + std::string(block_names[which]) + ": " +
                                (told ? "there it is " + formatted("%.3g ", told->rms) + unit + " rms, and "
                                 : lacks_columns ? "it lacks columns that this record has; "
                                                 : "none that can be told from the signal's steps; ") +
                                formatted("%.3g ", found.floor.rms) + unit + " is estimated from the record itself");
    }

    double cost_refitted(const block_diagnosis &known) const
    {
        block_model model(known.block, result_.data, result_.given, events_.fit,
                          records_.validation ? held_out_parts::none : held_out_parts::two_tenths);
        return fit(model, known.floor, known.fitted.rig, known.fitted.parameters, request_.options.replays_max).cost;
    }

    /* Reports and force are two witnesses of one motion. */
    void settle_robot_and_force(block_diagnosis &force, const block_start &start)
    {
        ask_force_about_robot(robot(), force, events_, before_, start, result_.given);
        let_unseen_force_tell_stand_in(robot(), force, events_, before_, start, result_.given);
        explain_robot_beside_shown(robot(), force, events_, before_, start, result_.given);
        doubt_reports(robot(), force, events_, before_, start);
        doubt_tolerances(robot(), force, result_.given);
        doubt_force(robot(), force, before_, events_);
    }

    void tell_earlier(const block_diagnosis &found)
    {
        for (block_diagnosis &earlier : result_.blocks) {
            drop_repeated(earlier, found);
            take_refined(earlier, found, result_.given);
            if (found.block == block::force && earlier.block == block::robot) {
                judge_robot_again(earlier, found, input_of(earlier.block), events_);
                measure_again(earlier, found.extended, input_of(earlier.block), events_);
            }
        }
    }

    /* A block that was not searched to the end is unknown, and not free of faults. */
    void doubt_what_was_cut(block_diagnosis &found, std::size_t left_out_before) const
    {
        const std::size_t count = limit_->left_out().size() - left_out_before;
        if (count == 0) {
            return;
        }
        found.doubts.push_back(
            formatted("the limit of %.3g s of processor time was over before all was tried", limit_->processor_s()));
        if (found.verdict == verdict::nothing_detectable) {
            found.verdict = verdict::unknown;
        }
    }

    const diagnosis_request &request_;
    std::shared_ptr<work_limit> limit_;
    records_of_request &records_;
    diagnosis &result_;
    events_of_records events_;
    std::vector<event_finding> repeats_;
    block_start before_;
    std::array<bool, 3> has_no_floor_{}; /* that a run made again has told; by block */
};

bool can_judge(const record &data, const rig &given, block which)
{
    return can_replay(data, which) && !(which == block::force && given.has_wandering_samples());
}

void refuse_if_none(const diagnosis &result, const rig &given)
{
    if (result.blocks.empty() && !result.not_described.empty()) {
        throw input_error(given.name + ": there is nothing to judge: " + result.notes.back());
    }
    if (result.blocks.empty()) {
        throw input_error(result.data.path +
                          ": no block can be replayed: a diagnosis needs operator_force_N or "
                          "operator_position_m with command_position_m, or command_position_m with "
                          "robot_position_m or force_N, or robot_position_m with force_N" +
                          (given.has_wandering_samples() ? "; " + result.notes.back() : ""));
    }
}

/* The one block that is at fault. */
std::string located(const std::vector<block_diagnosis> &blocks)
{
    std::string name;
    std::size_t at_fault = 0;
    for (const block_diagnosis &block : blocks) {
        if (block.verdict != verdict::nothing_detectable) {
            at_fault++;
            name = block_names[static_cast<int>(block.block)];
        }
    }
    return at_fault == 1 ? name : "";
}

} // namespace

diagnosis diagnose(const diagnosis_request &request)
{
    tell(request, "reading");
    records_of_request records = read_records(request);
    state_tolerances_of_effects(records.replayed);
    tell(request, "looking for late columns");
    const std::vector<late_column> late = put_late_columns_in_place(records);
    diagnosis result;
    result.data = std::move(records.fit);
    result.inputs = std::move(records.inputs);
    result.given = records.replayed;
    result.extended = records.replayed;
    if (!records.validation) {
        result.notes.push_back("two tenths of the record are held out; a record with another command as --validate "
                               "would be better evidence");
    }
    result.notes.insert(result.notes.end(), result.data.notes.begin(), result.data.notes.end());
    tell_sample_age(result, records.given);
    tell_tolerances_without_use(result, records.given);

    const double record_s = result.data.period_s * static_cast<double>(result.data.size());
    const auto limit = std::make_shared<work_limit>(request.limit_s.value_or(work_limit::usual_s(record_s)));
    blocks_in_turn blocks(request, limit, records, result);
    for (const block which : {block::manipulator, block::robot, block::force}) {
        if (!can_judge(result.data, records.given, which)) {
            continue;
        }
        const std::string_view section = missing_section(result.data, records.given, which);
        if (!section.empty()) {
            tell_not_described(result, which, section);
        } else {
            tell(request, looking_at(which));
            blocks.look_at(which);
        }
    }
    refuse_if_none(result, records.given);
    for (block_diagnosis &block : result.blocks) {
        drop_causes_as_given(block, records.replayed);
    }
    show_error_with_single_samples(result.blocks, result.data, records.validation ? &*records.validation : nullptr);
    tell_in_own_block(result.blocks);
    drop_what_explains_nothing(result.blocks, result.extended);
    tell_late_columns(result, late);
    tell_input_steps(result);
    tell_motion_noise(result, blocks.events());
    tell_scaled_manipulator(result);
    tell_other_zero_of_force(result);
    tell_delay_of_rows(result);
    const std::vector<std::string> uneven = noise_that_follows_motion(result.blocks, result.data);
    result.notes.insert(result.notes.end(), uneven.begin(), uneven.end());
    tell_not_tried(result, *limit);
    result.verdict = overall(result.blocks);
    tell(request, result.verdict == verdict::nothing_detectable ? "looking for what it would have shown"
                                                                : "looking for the next experiment");
    propose_next(result, blocks.events(), request, records.validation.has_value());
    result.extended = with_delay_of_age(result.extended, records.given);
    result.extended.tolerances = records.given.tolerances;
    result.given = records.given;
    result.located = located(result.blocks);
    return result;
}

} // namespace berth
