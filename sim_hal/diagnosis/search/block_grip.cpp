/* A grip that gives way beside another effect of the object. */
#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "../fit/grip_bisection.h"
#include "../fit/response.h"
#include "../fit/right_history.h"
#include "../noise/floor.h"
#include "../replay/held_rows.h"
#include "acceptance.h"
#include "block_search.h"

namespace berth
{

fit_result block_search::fit_base_here()
{
    fit_result base;
    base.rig = given_;
    base.parameters = own_parameters();
    base = fit(model_, noise_, base.rig, base.parameters, input_.options.base_replays_max);
    if (!has_floor_) {
        noise_ = floor_under(model_, base.rig);
        base = fit(model_, noise_, base.rig, base.parameters, input_.options.base_replays_max);
    }
    return base;
}

namespace
{

constexpr double per_row_suffices = 1.5; /* times the noise's own squares */

} // namespace

std::vector<candidate> block_search::candidates_while_held(const effect &grip)
{
    constexpr std::size_t followed = 2;
    const auto held = uses_while_held(model_, given_);
    if (!held) {
        return {};
    }
    const std::vector<row_use> uses = model_.uses();
    model_.use(*held);
    const fit_result base = fit_base_here();
    search_options others = input_.options;
    others.without.emplace_back(grip.name);
    std::vector<candidate> best = search_effects(model_, noise_, base, given_, found_, others);
    best.resize(std::min(best.size(), followed));
    if (!best.empty() && !has_floor_) {
        noise_ = floor_under(model_, best.front().fitted.rig);
    }
    for (candidate &one : best) {
        if (!one.effect->is_rough) {
            one.fitted = fit(model_, noise_, one.fitted.rig, one.fitted.parameters, input_.options.replays_max);
        }
    }
    model_.use(uses);
    return best;
}

namespace
{

/* Slopes across an instant that jumps say that all is known far too well. */
void widen_to(const fit_result &smooth, fit_result &fitted)
{
    for (std::size_t i = 0; i < smooth.ci95.size(); i++) {
        for (std::size_t j = 0; j < fitted.ci95.size(); j++) {
            if (fitted.parameters[j].key == smooth.parameters[i].key) {
                fitted.ci95[j] = std::max(fitted.ci95[j], smooth.ci95[i]);
            }
        }
    }
}

} // namespace

bool block_search::find_while_held(block_diagnosis &result)
{
    const bool has_grip_alone = found_.size() == 1 && found_.front()->decides_what_follows &&
                                incumbent_.cost > per_row_suffices * static_cast<double>(incumbent_.rows);
    if (model_.which() != block::force || input_.effects_max < 2 || (!found_.empty() && !has_grip_alone)) {
        return false;
    }
    const std::vector<const effect *> tried = effects_to_try(model_, given_, {}, input_.options);
    const auto grip =
        std::find_if(tried.begin(), tried.end(), [](const effect *one) { return one->decides_what_follows; });
    if (grip == tried.end()) {
        return false;
    }
    const fit_result before = incumbent_;
    const noise_model noise_before = noise_;
    const std::vector<const effect *> found_before = std::exchange(found_, {});
    const std::vector<cause> causes_before = std::exchange(result.causes, {});
    for (const candidate &one : candidates_while_held(**grip)) {
        if (adopt_with_grip(result, one, **grip)) {
            return true;
        }
    }
    found_ = found_before;
    result.causes = causes_before;
    incumbent_ = before;
    noise_ = noise_before;
    return false;
}

fit_result block_search::fit_grip_beside(const fit_result &while_held, const effect &grip)
{
    const std::string_view size_key = grip.parameters[0].key;
    const auto &force_N = model_.measured();
    const double most_N = -2.0 * *std::min_element(force_N.begin(), force_N.end());
    fit_result made = while_held;
    if (most_N > 0.0) {
        made.rig = with_bisected_grip(model_, noise_, while_held.rig, size_key, most_N);
        made.parameters = joined(while_held.parameters, effect_parameters(grip, made.rig));
        made.ci95.resize(made.parameters.size(), 0.0); /* the grip's own is found there */
        made.ci95_if_slow.resize(made.parameters.size(), 0.0);
        made.cost = cost_of(model_, noise_, made.rig);
        fit_where_right(model_, noise_, size_key, made, input_.options.replays_max);
    }
    if (most_N > 0.0 && made.cost < per_row_suffices * static_cast<double>(rows_under(noise_))) {
        return made;
    }
    const rig &held = while_held.rig;
    std::vector<double> error;
    model_.error(held, error);
    std::vector<rig> starts;
    for (const effect_values &values : grip.starts(held, scales_of(model_, held, error, input_.options))) {
        starts.push_back(with_values(held, grip, values));
    }
    fit_result other = fit_what_decides(model_, noise_, grip, while_held, starts, input_.options);
    fit_where_right(model_, noise_, size_key, other, input_.options.replays_max);
    return most_N > 0.0 && made.cost < other.cost ? made : other;
}

void block_search::fit_grip_anew(const effect &grip)
{
    const auto held = uses_while_held(model_, given_);
    if (!held || incumbent_.cost < per_row_suffices * static_cast<double>(incumbent_.rows)) {
        return;
    }
    const noise_model noise_before = noise_;
    const std::vector<row_use> uses = model_.uses();
    model_.use(*held);
    const fit_result base = fit_base_here();
    model_.use(uses);
    fit_result other = fit_grip_beside(base, grip);
    if (other.cost >= cost_of(model_, noise_, incumbent_.rig)) {
        noise_ = noise_before;
        return;
    }
    widen_to(base, other);
    other.rows = rows_under(noise_);
    incumbent_ = std::move(other);
}

bool block_search::adopt_with_grip(block_diagnosis &result, const candidate &while_held, const effect &grip)
{
    incumbent_.cost = cost_of(model_, noise_, incumbent_.rig);
    incumbent_.rows = rows_under(noise_);
    candidate both;
    both.effect = &grip;
    both.fitted = fit_grip_beside(while_held.fitted, grip);
    widen_to(while_held.fitted, both.fitted);
    both.fitted.rows = incumbent_.rows;
    both.bic = bic_of(both.fitted.cost, both.fitted.rows, both.fitted.parameters.size());
    if (both.fitted.cost > (1.0 - share_of_rest) * incumbent_.cost) {
        return false;
    }
    const fit_result before = incumbent_;
    const std::array<const effect *, 2> two{while_held.effect, &grip};
    std::array<cause, 2> causes;
    found_.insert(found_.end(), two.begin(), two.end());
    if (!prove_each(causes, both, two)) {
        found_.clear();
        incumbent_ = before;
        return false;
    }
    result.causes.insert(result.causes.end(), causes.begin(), causes.end());
    result.alternatives.clear();
    is_suspect_ = false;
    find_what_is_left();
    return true;
}

} // namespace berth
