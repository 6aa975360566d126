/* Two causes of one block that only together explain it. */
#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "../fit/manipulator_regression.h"
#include "acceptance.h"
#include "block_search.h"

namespace berth
{

bool block_search::prove_each(std::array<cause, 2> &causes, candidate both, const std::array<const effect *, 2> &two)
{
    for (std::size_t i = 0; i < two.size(); i++) {
        both.effect = two[i];
        if (!prove_exchange(causes[i], both)) {
            return false;
        }
    }
    return true;
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
    /* Two with one parameter each are no more than one with two. */
    const bool is_of_two = found_.size() == 1 && found_.back()->parameters.size() == 2;
    if (!is_of_two && incumbent_.cost < clear * static_cast<double>(incumbent_.rows)) {
        return;
    }
    const fit_result without = fit_without(*found_.back());
    const std::vector<const ranked *> others = others_weighed(result.ranking);
    std::array<const effect *, 2> two{};
    candidate best;
    best.bic = bic_better_by(bic_clear);
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
    if (!prove_each(causes, best, two)) {
        found_.pop_back();
        found_.back() = stand_in;
        incumbent_ = before;
        return;
    }
    result.causes.back() = causes[0];
    result.causes.push_back(causes[1]);
    result.alternatives.clear();
    is_suspect_ = false;
    drop_stand_ins(result);
    find_what_is_left();
}

bool block_search::may_be_two(const block_diagnosis &result)
{
    return std::any_of(found_.begin(), found_.end(), [&](const effect *one) {
        const bool is_smooth = !one->is_rough && one->switch_on == nullptr && one->parameters.size() == 2;
        return is_smooth && two_do_as_well_as(*one, result);
    });
}

bool block_search::two_do_as_well_as(const effect &one, const block_diagnosis &result)
{
    constexpr double as_well = 10.0; /* of the white sum of squares: one in 600 by chance */
    const bool is_alone_in_reports = found_.size() == 1 && model_.which() == block::robot;
    std::vector<const ranked *> others = others_weighed(result.ranking);
    others.erase(std::remove_if(others.begin(), others.end(),
                                [](const ranked *other) { return other->effect->parameters.size() != 1; }),
                 others.end());
    const double cost = cost_of(model_, noise_, incumbent_.rig);
    const fit_result without = fit_without(one);
    for (const ranked *const first : others) {
        if (!is_alone_in_reports && first->effect->name != one.generalises) {
            continue;
        }
        const fit_result with_first = fit_beside(without, *first);
        for (const ranked *const second : others) {
            if (first != second && fit_beside(with_first, *second).cost < cost + as_well) {
                return true;
            }
        }
    }
    return false;
}

candidate block_search::best_regressed_pair(std::array<const effect *, 2> &two)
{
    rig best = incumbent_.rig;
    double least = cost_of(model_, noise_, incumbent_.rig);
    for (const effect *const first : effects_to_try(model_, given_, found_, input_.options)) {
        std::vector<const effect *> with_first = found_;
        with_first.push_back(first);
        for (const effect *const second : effects_to_try(model_, given_, with_first, input_.options)) {
            for (const rig &start : regressed_starts(model_, incumbent_, with_first, *second)) {
                const double cost = cost_of(model_, noise_, start);
                if (cost < least) {
                    least = cost;
                    best = start;
                    two = {first, second};
                }
            }
        }
    }
    candidate made;
    if (two[0] == nullptr) {
        return made;
    }
    std::vector<const effect *> with_first = found_;
    with_first.push_back(two[0]);
    made.effect = two[1];
    made.fitted = fit(model_, noise_, best, parameters_about(best, incumbent_, with_first, *two[1]),
                      input_.options.replays_max);
    made.bic = bic_of(made.fitted.cost, made.fitted.rows, made.fitted.parameters.size());
    return made;
}

bool block_search::add_pair(block_diagnosis &result)
{
    if (model_.which() != block::manipulator || found_.empty() ||
        static_cast<int>(found_.size()) + 2 > input_.effects_max) {
        return false;
    }
    incumbent_.cost = cost_of(model_, noise_, incumbent_.rig);
    incumbent_.rows = rows_under(noise_);
    std::array<const effect *, 2> two{};
    candidate best = best_regressed_pair(two);
    if (best.effect == nullptr || best.bic > bic_better_by(bic_clear)) {
        return false;
    }
    const fit_result before = incumbent_;
    std::array<cause, 2> causes;
    found_.insert(found_.end(), two.begin(), two.end());
    if (!prove_each(causes, best, two)) {
        found_.resize(found_.size() - two.size());
        incumbent_ = before;
        return false;
    }
    result.causes.insert(result.causes.end(), causes.begin(), causes.end());
    result.alternatives.clear();
    is_suspect_ = false;
    start_over_from_other_scales();
    renew_floor();
    drop_stand_ins(result);
    find_what_is_left();
    return true;
}

bool block_search::bring_in_two(block_diagnosis &result)
{
    constexpr double above_floor = 1.2; /* of the white sum of squares that the noise has */
    constexpr int firsts_max = 3;
    incumbent_.cost = cost_of(model_, noise_, incumbent_.rig);
    incumbent_.rows = rows_under(noise_);
    if (is_rest_ || static_cast<int>(found_.size()) + 2 > input_.effects_max ||
        incumbent_.cost < above_floor * static_cast<double>(incumbent_.rows)) {
        return false;
    }
    const int round = static_cast<int>(found_.size()) + 1;
    std::vector<ranked> firsts;
    std::copy_if(result.ranking.begin(), result.ranking.end(), std::back_inserter(firsts), [&](const ranked &one) {
        return one.round == round && one.delta_bic > bic_beyond_doubt && one.effect->refines.empty() &&
               one.effect->switch_on == nullptr;
    });
    firsts.resize(std::min<std::size_t>(firsts.size(), firsts_max));
    const fit_result before = incumbent_;
    const noise_model noise_before = noise_;
    const std::vector<const effect *> found_before = found_;
    const leftover leftover_before = leftover_;
    const bool was_suspect = is_suspect_;
    const bool had_floor = has_floor_;
    for (const ranked &first : firsts) {
        block_diagnosis tried = result;
        if (starts_with(first, tried)) {
            result = std::move(tried);
            return true;
        }
        incumbent_ = before;
        noise_ = noise_before;
        found_ = found_before;
        leftover_ = leftover_before;
        is_suspect_ = was_suspect;
        has_floor_ = had_floor;
    }
    return false;
}

bool block_search::starts_with(const ranked &first, block_diagnosis &result)
{
    const double before = cost_of(model_, noise_, incumbent_.rig);
    const noise_model noise_before = noise_;
    const double explainable = before - static_cast<double>(rows_under(noise_));
    incumbent_ = first.fitted;
    found_.push_back(first.effect);
    result.causes.push_back({first.effect, {}, first.delta_bic});
    result.alternatives.clear(); /* the second one's are told */
    const std::size_t count = found_.size();
    if (!find_next(result) || found_.size() != count + 1 || found_[count - 1] != first.effect) {
        return false;
    }
    const double explained = before - cost_of(model_, noise_before, incumbent_.rig);
    if (explained < share_of_rest * explainable) {
        return false;
    }
    candidate both{first.effect, incumbent_, bic_of(incumbent_.cost, incumbent_.rows, incumbent_.parameters.size()),
                   incumbent_.cost};
    if (!prove_exchange(result.causes[count - 1], both)) {
        return false;
    }
    is_suspect_ = false;
    find_what_is_left();
    return true;
}

} // namespace berth
