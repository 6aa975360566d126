#include <algorithm>
#include <cmath>

#include "../../../hal/rig/units.h"
#include "../../effects/effect.h"
#include "../decide/criteria.h"
#include "../decide/printable.h"
#include "../decide/stretches.h"
#include "../formatted.h"
#include "acceptance.h"
#include "block_search.h"
#include "unseen_stretches.h"

namespace berth
{

bool block_search::has_no_size(const cause &told)
{
    const effect &known = *told.effect;
    const auto is_off = [&](std::string_view path, double value, double ci95) {
        return std::abs(value - value_of(given_, path)) > ci95;
    };
    /* What it was before a refinement of another cause, which may take its place. */
    if (!told.parameters.empty()) {
        return std::none_of(told.parameters.begin(), told.parameters.end(),
                            [&](const parameter_estimate &one) { return is_off(one.key, one.value, one.ci95); });
    }
    if (known.parameters.size() == 1 || value_of(given_, known.parameters[0].key) == 0.0) {
        return may_be_none(known);
    }
    /* Of several values that the rig file has, one that is off is enough. */
    for (std::size_t i = 0; i < incumbent_.ci95.size(); i++) {
        const std::string_view path = incumbent_.parameters[i].key->path;
        const bool is_own = std::any_of(known.parameters.begin(), known.parameters.end(),
                                        [&](const effect_parameter &own) { return own.key == path; });
        if (is_own && is_off(path, value_of(incumbent_.rig, path), incumbent_.ci95[i])) {
            return false;
        }
    }
    return true;
}

void block_search::add_crossed_stretches(cause_evidence &made, const effect &known, const fit_result &without)
{
    search_options half_as_long = input_.options;
    half_as_long.replays_max /= 2;
    for (const std::vector<row_use> &half : halves_by_tenths()) {
        block_model model(model_.which(), *input_.fit, given_, events_.fit, held_out_parts::none);
        model.use(half);
        const fit_result less = fit(model, noise_, without.rig, without.parameters, half_as_long.replays_max);
        const fit_result more = fit_effect(model, noise_, known, incumbent_, less, half_as_long);
        add_stretches(made, model, row_use::held_out, {more.rig, less.rig}, noise_.rms, unseen_stretches / 2);
    }
}

cause_evidence block_search::evidence_of(const cause &told, const fit_result &without)
{
    cause_evidence made{told.share_explained, has_no_size(told), {}, {}};
    block_model &model = unseen_ ? *unseen_ : model_;
    add_stretches(made, model, unseen_ ? row_use::fit : row_use::held_out, {incumbent_.rig, without.rig}, noise_.rms,
                  unseen_stretches);
    if (unseen_ == nullptr && made.unseen_with.size() < stretches_wanted) {
        made.unseen_with.clear();
        made.unseen_without.clear();
        add_crossed_stretches(made, *told.effect, without);
    }
    return made;
}

std::string block_search::withdraw_one(block_diagnosis &result)
{
    for (std::size_t i = result.causes.size(); i-- > 0;) {
        const effect &known = *result.causes[i].effect;
        fit_result without = fit_without(known);
        cause_evidence evidence = evidence_of(result.causes[i], without);
        const char *const reason = why_not_printable(evidence);
        result.causes[i].evidence = std::move(evidence);
        if (reason == nullptr) {
            continue;
        }
        const std::vector<const effect *> gone = with_refinements(known);
        const auto is_gone = [&](const effect *one) {
            return std::find(gone.begin(), gone.end(), one) != gone.end();
        };
        found_.erase(std::remove_if(found_.begin(), found_.end(), is_gone), found_.end());
        result.causes.erase(std::remove_if(result.causes.begin(), result.causes.end(),
                                           [&](const cause &one) { return is_gone(one.effect); }),
                            result.causes.end());
        incumbent_ = std::move(without);
        widen_by_what_is_left();
        return std::string(known.name) + " was fitted, and " + reason;
    }
    return "";
}

bool block_search::withdraw_what_is_not_printable(block_diagnosis &result)
{
    std::vector<std::string> why;
    for (std::string one = withdraw_one(result); !one.empty(); one = withdraw_one(result)) {
        why.push_back(std::move(one));
    }
    if (why.empty()) {
        return false;
    }
    for (cause &told : result.causes) {
        told.parameters.clear(); /* what it is without those that are gone */
    }
    find_what_is_left();
    result.doubts.clear();
    const verdict left = verdict_of(result);
    result.verdict = left == verdict::nothing_detectable ? verdict::unknown : left;
    result.doubts.insert(result.doubts.end(), why.begin(), why.end());
    if (result.verdict == verdict::named || result.verdict == verdict::one_of) {
        result.verdict = verdict::partly_explained;
    }
    return true;
}

double block_search::unseen_mean_square(const rig &rig)
{
    block_model &model = unseen_ ? *unseen_ : model_;
    std::vector<double> error;
    model.error(rig, error);
    return std::pow(rms_of(error, model.uses(), unseen_ ? row_use::fit : row_use::held_out), 2);
}

void block_search::name_rivals_on_unseen(block_diagnosis &result)
{
    if (found_.size() != 1 || input_.has_cause_upstream || input_.without_switching_fault != nullptr) {
        return;
    }
    const double best = unseen_mean_square(incumbent_.rig);
    const double left = best - noise_.rms * noise_.rms;
    for (const ranked &other : result.ranking) {
        const auto is_same = [&](const alternative &one) { return one.effect == other.effect; };
        const bool is_known = other.effect == found_[0] ||
                              std::any_of(result.alternatives.begin(), result.alternatives.end(), is_same);
        if (other.round == 1 && !is_known && other.share_explained > share_worthwhile &&
            unseen_mean_square(other.fitted.rig) - best < left) {
            result.alternatives.push_back({other.effect, result.causes[0].delta_bic - other.delta_bic});
        }
    }
}

void block_search::name_rivals_of_a_short_delay(block_diagnosis &result)
{
    if (found_.size() != 1 || input_.has_cause_upstream) {
        return;
    }
    const effect &known = *found_[0];
    const effect_parameter &delay = known.parameters[0];
    const double found_ms = value_of(incumbent_.rig, delay.key);
    const bool is_delay = delay.meaning.empty() && known.parameters.size() == 1 && unit_of(delay.key) == "ms";
    if (!is_delay || found_ms >= 1e3 * model_.data().period_s) {
        return;
    }
    const double best = unseen_mean_square(incumbent_.rig);
    const double left = best - noise_.rms * noise_.rms;
    for (const effect &other : effect_library()) {
        if (other.look_alike != known.name || other.block() != known.block()) {
            continue;
        }
        fit_result start = incumbent_;
        set_number(start.rig, delay.key, 0.0);
        set_number(start.rig, other.parameters[0].key, found_ms);
        start.parameters.erase(std::remove_if(start.parameters.begin(), start.parameters.end(),
                                              [&](const auto &free) { return free.key->path == delay.key; }),
                               start.parameters.end());
        const fit_result instead =
            fit(model_, noise_, start.rig, joined(start.parameters, effect_parameters(other, start.rig)),
                input_.options.replays_max);
        if (unseen_mean_square(instead.rig) - best < left) {
            result.alternatives.push_back(
                {&other, bic_of(instead.cost, incumbent_.rows, instead.parameters.size()) - bic_better_by(0.0),
                 nullptr, instead});
        }
    }
}

void block_search::admit_failure_on_unseen(block_diagnosis &result)
{
    const bool is_excused = input_.has_cause_upstream || input_.without_switching_fault != nullptr;
    const double times_noise = result.held_out_rms.after / noise_.rms;
    if (unseen_ == nullptr || is_excused || is_of_our_steps(*unseen_) || !(times_noise > criteria::unseen_far)) {
        return;
    }
    result.unseen_times_noise = times_noise;
    result.doubts.insert(result.doubts.begin(),
                         formatted("on the validation record the error is %.2g times the noise", times_noise));
    name_rivals_on_unseen(result);
    if (result.verdict == verdict::nothing_detectable) {
        result.verdict = verdict::unknown;
    } else if (result.verdict != verdict::unknown) {
        result.verdict = verdict::partly_explained;
    }
}

} // namespace berth
