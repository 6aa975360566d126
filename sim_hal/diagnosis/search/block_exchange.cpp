#include <algorithm>
#include <initializer_list>
#include <utility>

#include "../fit/response.h"
#include "acceptance.h"
#include "block_search.h"

namespace berth
{

void block_search::exchange_stand_ins(block_diagnosis &result)
{
    const auto is_of_earlier = [](const alternative &one) { return one.rival_of != nullptr; };
    result.alternatives.erase(std::remove_if(result.alternatives.begin(), result.alternatives.end(), is_of_earlier),
                              result.alternatives.end());
    /* What has taken a place may stand in for another one again: a dead time, first for a lag, for a resonance. */
    constexpr int in_a_row_max = 2;
    bool any = false;
    for (std::size_t i = 0; i + 1 < found_.size(); i++) {
        for (int k = 0; k < in_a_row_max && exchange_stand_in(result, i); k++) {
            any = true;
        }
    }
    if (any) {
        drop_stand_ins(result);
    }
}

bool block_search::exchange_stand_in(block_diagnosis &result, std::size_t i)
{
    const effect &known = *found_[i];
    const bool is_refined =
        std::any_of(found_.begin(), found_.end(), [&](const effect *other) { return other->refines == known.name; });
    if (is_refined || known.is_rough || known.switch_on != nullptr) {
        return false;
    }
    const auto other = rival_of(known, result.ranking);
    const bool is_simpler = other && known.generalises == other->effect->name;
    if (other && !is_simpler && other->bic > bic_better_by(bic_undecided)) {
        result.alternatives.push_back({other->effect, other->bic - bic_better_by(0.0), &known, other->fitted});
        return false;
    }
    if (!other || !prove_exchange(result.causes[i], *other)) {
        return false;
    }
    found_[i] = other->effect;
    const auto is_other = [&](const alternative &one) { return one.effect == other->effect; };
    result.alternatives.erase(std::remove_if(result.alternatives.begin(), result.alternatives.end(), is_other),
                              result.alternatives.end());
    return true;
}

std::vector<rig> block_search::starts_beside(const rig &others, const ranked &known)
{
    constexpr std::size_t followed = 2;
    std::vector<double> error;
    model_.error(others, error);
    std::vector<std::pair<double, rig>> starts;
    const auto add = [&](const rig &start) { starts.emplace_back(cost_of(model_, noise_, start), start); };
    rig as_weighed = others;
    for (const effect_parameter &parameter : known.effect->parameters) {
        set_number(as_weighed, parameter.key, value_of(known.fitted.rig, parameter.key));
    }
    add(as_weighed);
    for (const effect_values &values :
         known.effect->starts(others, scales_of(model_, others, error, input_.options))) {
        add(with_values(others, *known.effect, values));
    }
    std::sort(starts.begin(), starts.end(), [](const auto &a, const auto &b) { return a.first < b.first; });
    std::vector<rig> best;
    for (std::size_t i = 0; i < std::min(followed, starts.size()); i++) {
        best.push_back(starts[i].second);
    }
    return best;
}

fit_result block_search::fit_beside(const fit_result &others, const ranked &known)
{
    fit_result best;
    best.cost = unlimited;
    for (const rig &start : starts_beside(others.rig, known)) {
        const auto parameters = joined(others.parameters, effect_parameters(*known.effect, start));
        fit_result fitted = fit(model_, noise_, start, parameters, input_.options.replays_max);
        if (fitted.cost < best.cost) {
            best = std::move(fitted);
        }
    }
    best.rows = incumbent_.rows;
    return best;
}

std::vector<const ranked *> block_search::others_weighed(const std::vector<ranked> &ranking) const
{
    std::vector<const effect *> known = found_;
    std::vector<const ranked *> others;
    for (auto at = ranking.rbegin(); at != ranking.rend(); ++at) {
        const effect &one = *at->effect;
        const bool is_smooth = !one.is_rough && one.switch_on == nullptr && one.refines.empty();
        if (is_smooth && at->delta_bic > 0.0 && std::find(known.begin(), known.end(), &one) == known.end()) {
            known.push_back(&one);
            others.push_back(&*at);
        }
    }
    return others;
}

double block_search::bic_better_by(double improvement) const
{
    return bic_of(incumbent_.cost, incumbent_.rows, incumbent_.parameters.size()) - improvement;
}

std::optional<candidate> block_search::rival_of(const effect &known, const std::vector<ranked> &ranking)
{
    const fit_result without = fit_without(known);
    candidate best;
    best.bic = unlimited;
    /* The others fitted without it may have gone astray, as a periodic error behind a motion that is late otherwise.
     */
    fit_result as_they_are;
    as_they_are.rig = rig_without(known);
    as_they_are.parameters = without.parameters;
    const record_scales scales = scales_of(model_, incumbent_.rig, error_left(), input_.options);
    for (const ranked *const one : others_weighed(ranking)) {
        if (one->effect->generalises == known.name) {
            continue; /* the same with more parameters */
        }
        const bool is_simpler = known.generalises == one->effect->name;
        for (const fit_result *const others : std::initializer_list<const fit_result *>{&without, &as_they_are}) {
            fit_result tried = fit_beside(*others, *one);
            if (one->effect->is_seen != nullptr && !one->effect->is_seen(tried.rig, scales)) {
                continue;
            }
            const double bic = bic_of(tried.cost, tried.rows, tried.parameters.size());
            /* With more parameters it may do nearly the same, as a damped resonance does what a lag does. */
            const bool is_larger = one->effect->parameters.size() > known.parameters.size();
            const bool is_look_alike =
                one->effect->look_alike == known.name && known.look_alike == one->effect->name;
            const double asked = is_larger       ? bic_better_by(bic_undecided)
                                 : is_simpler    ? bic_better_by(0.0)
                                 : is_look_alike ? bic_better_by(-bic_look_alike)
                                                 : bic_better_by(-bic_undecided);
            if (bic < std::min(best.bic, asked)) {
                best = {one->effect, std::move(tried), bic, 0.0};
            }
        }
    }
    return best.effect == nullptr ? std::nullopt : std::optional(std::move(best));
}

bool block_search::prove_exchange(cause &known, const candidate &other)
{
    const fit_result before = incumbent_;
    incumbent_ = other.fitted;
    fit_result without = fit_without(*other.effect);
    without.rows = before.rows;
    incumbent_ = without;
    metric_ = noise_;
    const gain gained = gain_of(other, false);
    if (gained.low <= 0.0) {
        incumbent_ = before;
        return false;
    }
    known = {other.effect, {}, bic_of(without.cost, without.rows, without.parameters.size()) - other.bic};
    known.share_explained = std::min(1.0, (without.cost - other.fitted.cost) / excess(without.cost, without.rows));
    known.held_out_gain = gained.value;
    known.held_out_gain_low = gained.low;
    known.held_out_gain_high = gained.high;
    incumbent_ = other.fitted;
    return true;
}

} // namespace berth
