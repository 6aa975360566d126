#include <algorithm>
#include <cmath>

#include "../../../hal/rig/units.h"
#include "../../effects/effect.h"
#include "../decide/criteria.h"
#include "../decide/printable.h"
#include "../formatted.h"
#include "acceptance.h"
#include "block_search.h"

namespace berth
{

namespace
{

constexpr std::size_t stretches = 12; /* of the unseen rows: enough that a normal quantile holds for their sum */

/* Squares of the rows with this use, shared over the stretches in their order. */
std::vector<double> squares_by_stretch(const std::vector<double> &error, const std::vector<row_use> &uses,
                                       row_use use)
{
    const auto rows = static_cast<std::size_t>(std::count(uses.begin(), uses.end(), use));
    std::vector<double> sums(stretches, 0.0);
    std::size_t row = 0;
    for (std::size_t n = 0; n < uses.size(); n++) {
        if (uses[n] == use) {
            sums[row * stretches / rows] += error[n] * error[n];
            row++;
        }
    }
    return sums;
}

} // namespace

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

cause_evidence block_search::evidence_of(const cause &told, const rig &without)
{
    cause_evidence made{told.share_explained, has_no_size(told), {}, {}};
    block_model &model = unseen_ ? *unseen_ : model_;
    const row_use use = unseen_ ? row_use::fit : row_use::held_out;
    std::vector<double> with_it;
    std::vector<double> without_it;
    model.error(incumbent_.rig, with_it);
    model.error(without, without_it);
    std::vector<double> change = with_it;
    std::transform(change.begin(), change.end(), without_it.begin(), change.begin(), std::minus<>());
    const auto rows = static_cast<double>(std::count(model.uses().begin(), model.uses().end(), use));
    const double noise_of_stretch = noise_.rms * noise_.rms * rows / static_cast<double>(stretches);
    const std::vector<double> shown = squares_by_stretch(change, model.uses(), use);
    const std::vector<double> with = squares_by_stretch(with_it, model.uses(), use);
    const std::vector<double> without_cause = squares_by_stretch(without_it, model.uses(), use);
    /* A model in which a refinement does the same proves nothing either. */
    for (std::size_t i = 0; i < stretches && told.parameters.empty(); i++) {
        if (shown[i] > noise_of_stretch) {
            made.unseen_with.push_back(with[i]);
            made.unseen_without.push_back(without_cause[i]);
        }
    }
    return made;
}

bool block_search::withdraw_what_is_not_printable(block_diagnosis &result)
{
    std::vector<std::string> why;
    for (std::size_t i = result.causes.size(); i-- > 0;) {
        const effect &known = *result.causes[i].effect;
        const bool is_refined = std::any_of(found_.begin(), found_.end(),
                                            [&](const effect *other) { return other->refines == known.name; });
        if (is_refined || found_[i] != &known) {
            continue;
        }
        fit_result without = fit_without(known);
        const char *const reason = why_not_printable(evidence_of(result.causes[i], without.rig));
        if (reason == nullptr) {
            continue;
        }
        why.push_back(std::string(known.name) + " was fitted, and " + reason);
        incumbent_ = std::move(without);
        found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(i));
        result.causes.erase(result.causes.begin() + static_cast<std::ptrdiff_t>(i));
        widen_by_what_is_left();
    }
    if (why.empty()) {
        return false;
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
                {&other, bic_of(instead.cost, incumbent_.rows, instead.parameters.size()) - bic_better_by(0.0)});
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
