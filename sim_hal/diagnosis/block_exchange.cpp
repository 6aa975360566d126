#include <algorithm>
#include <utility>

#include "acceptance.h"
#include "block_search.h"
#include "response.h"

namespace berth
{

void block_search::exchange_stand_ins(block_diagnosis &result)
{
    bool any = false;
    for (std::size_t i = 0; i + 1 < found_.size(); i++) {
        const effect &known = *found_[i];
        const bool is_refined = std::any_of(found_.begin(), found_.end(),
                                            [&](const effect *other) { return other->refines == known.name; });
        if (is_refined || known.is_rough || known.switch_on != nullptr) {
            continue;
        }
        const auto other = better_than(known, result.ranking);
        if (other && prove_exchange(result.causes[i], *other)) {
            found_[i] = other->effect;
            const auto is_other = [&](const alternative &one) { return one.effect == other->effect; };
            result.alternatives.erase(
                std::remove_if(result.alternatives.begin(), result.alternatives.end(), is_other),
                result.alternatives.end());
            any = true;
        }
    }
    if (any) {
        drop_stand_ins(result);
    }
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

double block_search::bic_of_exchange() const
{
    return bic_of(incumbent_.cost, incumbent_.rows, incumbent_.parameters.size()) - bic_clear;
}

std::optional<candidate> block_search::better_than(const effect &known, const std::vector<ranked> &ranking)
{
    const fit_result without = fit_without(known);
    candidate best;
    best.bic = bic_of_exchange();
    for (const ranked *const one : others_weighed(ranking)) {
        fit_result tried = fit_beside(without, *one);
        const double bic = bic_of(tried.cost, tried.rows, tried.parameters.size());
        if (bic < best.bic) {
            best = {one->effect, std::move(tried), bic, 0.0};
        }
    }
    return best.effect == nullptr ? std::nullopt : std::optional(std::move(best));
}

void block_search::divide_stand_in(block_diagnosis &result)
{
    constexpr double clear = 1.2; /* of the white sum of squares that the noise has */
    const bool may_be = !found_.empty() && static_cast<int>(found_.size()) < input_.effects_max &&
                        !found_.back()->is_rough && found_.back()->switch_on == nullptr &&
                        found_.back()->refines.empty() && model_.which() == block::robot;
    if (!may_be) {
        return;
    }
    incumbent_.cost = cost_of(model_, noise_, incumbent_.rig);
    incumbent_.rows = rows_under(noise_);
    if (incumbent_.cost < clear * static_cast<double>(incumbent_.rows)) {
        return;
    }
    const fit_result without = fit_without(*found_.back());
    const std::vector<const ranked *> others = others_weighed(result.ranking);
    std::array<const effect *, 2> two{};
    candidate best;
    best.bic = bic_of_exchange();
    for (const ranked *const first : others) {
        const fit_result with_first = fit_beside(without, *first);
        for (const ranked *const second : others) {
            if (first == second) {
                continue;
            }
            fit_result tried = fit_beside(with_first, *second);
            const double bic = bic_of(tried.cost, tried.rows, tried.parameters.size());
            if (bic < best.bic) {
                best = {nullptr, std::move(tried), bic, 0.0};
                two = {first->effect, second->effect};
            }
        }
    }
    if (two[0] == nullptr) {
        return;
    }
    const fit_result before = incumbent_;
    const effect *const stand_in = found_.back();
    std::array<cause, 2> causes;
    found_.back() = two[0];
    found_.push_back(two[1]);
    for (std::size_t i = 0; i < two.size(); i++) {
        best.effect = two[i];
        if (!prove_exchange(causes[i], best)) {
            found_.pop_back();
            found_.back() = stand_in;
            incumbent_ = before;
            return;
        }
    }
    result.causes.back() = causes[0];
    result.causes.push_back(causes[1]);
    result.alternatives.clear();
    is_suspect_ = false;
    drop_stand_ins(result);
    std::vector<double> error;
    model_.error(incumbent_.rig, error);
    leftover_ = find_leftover(model_, noise_, incumbent_.rig, error);
}

bool block_search::may_be_two(const block_diagnosis &result)
{
    constexpr double as_well = 10.0; /* of the white sum of squares: one in 600 by chance */
    const bool is_one = found_.size() == 1 && model_.which() == block::robot && !found_[0]->is_rough &&
                        found_[0]->switch_on == nullptr && found_[0]->parameters.size() == 2;
    if (!is_one) {
        return false;
    }
    std::vector<const ranked *> others = others_weighed(result.ranking);
    others.erase(std::remove_if(others.begin(), others.end(),
                                [](const ranked *one) { return one->effect->parameters.size() != 1; }),
                 others.end());
    const double cost = cost_of(model_, noise_, incumbent_.rig);
    const fit_result without = fit_without(*found_[0]);
    for (const ranked *const first : others) {
        const fit_result with_first = fit_beside(without, *first);
        for (const ranked *const second : others) {
            if (first != second && fit_beside(with_first, *second).cost < cost + as_well) {
                return true;
            }
        }
    }
    return false;
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
