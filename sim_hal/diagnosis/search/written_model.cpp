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
        return without(gone, extended, told_.fitted.parameters);
    }

    fit_result without(const std::vector<const effect *> &gone, const rig &all,
                       const std::vector<free_parameter> &parameters)
    {
        const std::vector<free_parameter> base = base_parameters(told_.block, told_.as_given);
        return fit(model_, told_.floor, switched_off(all, gone, base, told_.as_given),
                   joined(base, parameters_of_others(parameters, gone)), records_.replays_max);
    }

    /* With intervals, which a first look has not. */
    fit_result known_well(const fit_result &fitted)
    {
        return fitted.ci95.empty() ? fit(model_, told_.floor, fitted.rig, fitted.parameters, records_.replays_max)
                                   : fitted;
    }

    cause_evidence evidence(const fit_result &with, const fit_result &without)
    {
        cause_evidence made;
        add_gain(made, with.rig, without.rig);
        if (unseen_ == nullptr && made.unseen_with.size() < stretches_wanted) {
            made = {};
            add_crossed_gain(made, with, without);
        }
        return made;
    }

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
    void add_crossed_gain(cause_evidence &made, const fit_result &with, const fit_result &without)
    {
        for (const held_out_parts parts : {held_out_parts::odd, held_out_parts::even}) {
            block_model half(told_.block, records_.fit, told_.as_given, records_.events.fit, parts);
            const fit_result more = fit(half, told_.floor, with.rig, with.parameters, records_.replays_max / 2);
            const fit_result less =
                fit(half, told_.floor, without.rig, without.parameters, records_.replays_max / 2);
            add_stretches(made, half, row_use::held_out, {more.rig, less.rig}, told_.floor.rms,
                          unseen_stretches / 2);
        }
    }

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
bool may_be_none(const std::vector<parameter_estimate> &parameters, const effect &known, const rig &given)
{
    const auto is_off = [&](const parameter_estimate &one) {
        const double as_given = value_of(given, one.key);
        return std::abs(as_given < unlimited ? one.value - as_given : one.value) > one.ci95;
    };
    const std::size_t own = std::min(parameters.size(), known.parameters.size());
    const auto first = parameters.begin();
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
        fit_result with = told.fitted;
        with.rig = extended;
        cause_evidence evidence = block.evidence(with, without);
        evidence.share_explained = known.share_explained;
        evidence.may_be_none = may_be_none(known.parameters, *known.effect, told.as_given);
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

/* What a rival was fitted to: by itself, or in the last round of the search. */
const fit_result *fit_of(const alternative &rival, const block_diagnosis &told)
{
    if (!rival.fitted.parameters.empty()) {
        return &rival.fitted;
    }
    const auto known = std::find_if(told.ranking.rbegin(), told.ranking.rend(),
                                    [&](const ranked &one) { return one.effect == rival.effect; });
    return known == told.ranking.rend() ? nullptr : &known->fitted;
}

/* nullptr: it is one. */
const char *why_withdrawn(const alternative &rival, const block_diagnosis &told, written_block &block)
{
    const fit_result *const known = fit_of(rival, told);
    if (known == nullptr) {
        return "was not fitted";
    }
    const fit_result fitted = block.known_well(*known);
    std::vector<parameter_estimate> own;
    for (const effect_parameter &parameter : rival.effect->parameters) {
        for (std::size_t i = 0; i < fitted.ci95.size(); i++) {
            if (fitted.parameters[i].key->path == parameter.key) {
                own.push_back({std::string(parameter.key), value_of(fitted.rig, parameter.key), fitted.ci95[i]});
            }
        }
    }
    cause_evidence evidence = block.evidence(fitted, block.without({rival.effect}, fitted.rig, fitted.parameters));
    evidence.may_be_none = own.empty() || may_be_none(own, *rival.effect, told.as_given);
    return why_no_rival(evidence);
}

/* One that is left alone is not named outright: what was as good may be so by another name. */
void judge_rivals(block_diagnosis &told, const written_records &records)
{
    written_block block(told, records);
    for (std::size_t i = told.alternatives.size(); i-- > 0;) {
        const char *const why = why_withdrawn(told.alternatives[i], told, block);
        if (why == nullptr) {
            continue;
        }
        const std::string name(told.alternatives[i].effect->name);
        told.alternatives.erase(told.alternatives.begin() + static_cast<std::ptrdiff_t>(i));
        if (told.alternatives.empty()) {
            told.verdict = verdict::partly_explained;
            told.doubts.push_back(name + " was as good, and " + why);
        }
    }
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
        if (told.verdict == verdict::one_of) { /* elsewhere what is told beside a cause says that it is not proven */
            judge_rivals(told, records);
        }
        if (any) {
            written_block(told, records).measure(told, extended);
        }
    }
}

} // namespace berth
