#include "written_model.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "../decide/stretches.h"
#include "../fit/base.h"
#include "../samples/clock_slips.h"
#include "switched_off.h"
#include "unseen_stretches.h"

namespace berth
{

namespace
{

bool is_fitted(const cause &known)
{
    return !known.effect->is_of_single_samples;
}

/* A block of the written model, on the rows of the fit and on those that no fit has seen. */
class written_block
{
  public:
    written_block(const block_diagnosis &told, const written_records &records)
        : told_(told), records_(records),
          model_(told.block, records.fit, told.as_given, records.events.fit, held_out_parts::none)
    {
        model_.use(told.uses);
        if (records.validation != nullptr && can_replay(*records.validation, told.block)) {
            unseen_ = std::make_unique<block_model>(told.block, *records.validation, told.as_given,
                                                    records.events.unseen, held_out_parts::none);
        }
    }

    fit_result without(const cause &known, const rig &extended)
    {
        std::vector<const effect *> gone{known.effect};
        for (const cause &other : told_.causes) {
            if (other.effect->refines == known.effect->name) {
                gone.push_back(other.effect);
            }
        }
        const std::vector<free_parameter> base = base_parameters(told_.block, told_.as_given);
        return fit(model_, told_.floor, switched_off(extended, gone, base, told_.as_given),
                   joined(base, parameters_of_others(told_.fitted.parameters, gone)), records_.replays_max);
    }

    void add_gain(cause_evidence &made, const rig &with, const rig &without)
    {
        if (unseen_ == nullptr) {
            add_stretches(made, model_, row_use::held_out, {with, without}, told_.floor.rms, unseen_stretches);
            return;
        }
        const std::vector<row_use> uses = unseen_->uses();
        if (with.robot.clock == robot_clock::free && told_.block == block::force) {
            unseen_->use(uses_beside_slips(*unseen_, with));
        }
        add_stretches(made, *unseen_, row_use::fit, {with, without}, told_.floor.rms, unseen_stretches);
        unseen_->use(uses);
    }

    /* The record's odd parts, with all parameters fitted to its even ones, and the other way round. */
    void add_crossed_gain(cause_evidence &made, const rig &with, const fit_result &without)
    {
        for (const held_out_parts parts : {held_out_parts::odd, held_out_parts::even}) {
            block_model half(told_.block, records_.fit, told_.as_given, records_.events.fit, parts);
            const fit_result more = fit(half, told_.floor, with, told_.fitted.parameters, records_.replays_max / 2);
            const fit_result less =
                fit(half, told_.floor, without.rig, without.parameters, records_.replays_max / 2);
            add_stretches(made, half, row_use::held_out, {more.rig, less.rig}, told_.floor.rms,
                          unseen_stretches / 2);
        }
    }

    bool has_validation() const { return unseen_ != nullptr; }

    void measure(block_diagnosis &told, const rig &extended)
    {
        model_.error(extended, told.error_after);
        told.fit_rms.after = rms_of(told.error_after, told.uses, row_use::fit);
        std::vector<double> error = told.error_after;
        block_model &unseen = unseen_ ? *unseen_ : model_;
        unseen.error(extended, error);
        told.held_out_rms.after = rms_of(error, unseen.uses(), unseen_ ? row_use::fit : row_use::held_out);
    }

  private:
    const block_diagnosis &told_;
    const written_records &records_;
    block_model model_;
    std::unique_ptr<block_model> unseen_;
};

void withdraw(block_diagnosis &told, std::size_t i, const char *why)
{
    const effect &gone = *told.causes[i].effect;
    told.doubts.push_back(std::string(gone.name) + " was fitted, and with all causes together it " + why);
    told.causes.erase(
        std::remove_if(told.causes.begin(), told.causes.end(),
                       [&](const cause &one) { return one.effect == &gone || one.effect->refines == gone.name; }),
        told.causes.end());
    told.verdict = told.causes.empty() ? verdict::unknown : verdict::partly_explained;
    const bool is_last = told.causes.empty();
    told.alternatives.erase(std::remove_if(told.alternatives.begin(), told.alternatives.end(),
                                           [&](const alternative &one) { return is_last || one.rival_of == &gone; }),
                            told.alternatives.end());
}

/* Its interval, as it is told, holds the size at which it does nothing; of several values that the rig file has, all
 * of them do. */
bool may_be_none(const cause &known, const rig &given)
{
    const auto is_off = [&](const parameter_estimate &one) {
        const double as_given = value_of(given, one.key);
        return std::abs(as_given < unlimited ? one.value - as_given : one.value) > one.ci95;
    };
    const std::size_t own = std::min(known.parameters.size(), known.effect->parameters.size());
    const auto first = known.parameters.begin();
    const bool has_size = own == 1 || value_of(given, first->key) == 0.0;
    return std::none_of(first, first + static_cast<std::ptrdiff_t>(has_size ? 1 : own), is_off);
}

/* Whether one is gone. */
bool judge_block(block_diagnosis &told, rig &extended, const written_records &records)
{
    written_block block(told, records);
    for (std::size_t i = told.causes.size(); i-- > 0;) {
        cause &known = told.causes[i];
        if (!is_fitted(known)) {
            continue;
        }
        const fit_result without = block.without(known, extended);
        cause_evidence evidence{known.share_explained, may_be_none(known, told.as_given), {}, {}};
        block.add_gain(evidence, extended, without.rig);
        if (!block.has_validation() && evidence.unseen_with.size() < stretches_wanted) {
            evidence.unseen_with.clear();
            evidence.unseen_without.clear();
            block.add_crossed_gain(evidence, extended, without);
        }
        if (const char *const why = why_not_printable(evidence)) {
            withdraw(told, i, why);
            extended = without.rig;
            told.extended = extended;
            return true;
        }
        say_of(known, evidence);
    }
    return false;
}

} // namespace

void say_of(cause &known, const cause_evidence &evidence)
{
    const unseen_gain gained = gain_of(evidence);
    known.evidence = evidence;
    known.held_out_gain = gained.value;
    known.held_out_gain_low = gained.low;
    known.held_out_gain_high = gained.high;
    known.probability = probability_of(evidence, is_fitted(known) ? known.delta_bic : unlimited);
}

void judge_written_model(std::vector<block_diagnosis> &blocks, rig &extended, const written_records &records)
{
    bool any = false;
    const auto judge_all = [&] {
        return std::any_of(blocks.begin(), blocks.end(),
                           [&](block_diagnosis &told) { return judge_block(told, extended, records); });
    };
    while (judge_all()) {
        any = true;
    }
    for (block_diagnosis &told : blocks) {
        if (any) {
            written_block(told, records).measure(told, extended);
        }
    }
}

} // namespace berth
