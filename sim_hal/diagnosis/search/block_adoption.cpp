#include <algorithm>
#include <cmath>
#include <iterator>

#include "../fit/right_history.h"
#include "../noise/floor.h"
#include "../samples/clock_slips.h"
#include "../samples/clock_ways.h"
#include "acceptance.h"
#include "block_search.h"

namespace berth
{

namespace
{

/* `precision`: see effect. */
std::vector<parameter_estimate> estimates(const fit_result &fitted, const effect &effect, double precision)
{
    std::vector<parameter_estimate> all;
    for (const effect_parameter &parameter : effect.parameters) {
        double ci95 = 0.0;
        for (std::size_t i = 0; i < fitted.parameters.size() && i < fitted.ci95.size(); i++) {
            if (fitted.parameters[i].key->path == parameter.key) {
                ci95 = fitted.ci95[i];
            }
        }
        const double value = value_of(fitted.rig, parameter.key);
        const bool is_fitted = ci95 > 0.0;
        all.push_back({std::string(parameter.key), value, is_fitted ? std::hypot(ci95, precision * value) : 0.0});
    }
    return all;
}

} // namespace

void block_search::adopt(block_diagnosis &result, const candidate &best)
{
    incumbent_ = best.fitted;
    if (best.effect->switch_on != nullptr) {
        polish_clock(model_, noise_, incumbent_);
        if (unseen_ == nullptr && hold_out_beside_slips()) {
            polish_clock(model_, noise_, incumbent_);
        }
    }
    if (!best.effect->is_rough) {
        fit_behind_switching();
        fit_without_colour();
        incumbent_ = fit(model_, noise_, incumbent_.rig, incumbent_.parameters, input_.options.replays_max);
    }
    incumbent_.cost = cost_of(model_, noise_, incumbent_.rig);
    incumbent_.rows = rows_under(noise_);
    if (best.effect->is_rough) {
        fit_where_right(model_, noise_, best.effect->parameters[0].key, incumbent_, input_.options.replays_max);
    }
    if (best.effect->decides_what_follows && found_.size() == 1) {
        fit_grip_anew(*best.effect);
    }
    start_over_from_given();
    start_over_from_other_scales();
    renew_floor();
    drop_stand_ins(result);
    exchange_stand_ins(result);
    find_what_is_left();
}

bool block_search::hold_out_beside_slips()
{
    constexpr double clear = 0.5; /* tenths: reports that are mostly noise leave a slip that open */
    const record &data = model_.data();
    const std::vector<double> slips_s = slip_times_s(incumbent_.rig, data);
    const double begin_s = data.time_s.front() - data.time_origin_s;
    const double tenth_s = 0.1 * data.period_s * static_cast<double>(data.size());
    const auto distance = [&](const std::array<std::size_t, 2> &tenths) {
        double least = unlimited;
        for (const double time_s : slips_s) {
            for (const std::size_t tenth : tenths) {
                const double beyond = (time_s - begin_s) / tenth_s - static_cast<double>(tenth);
                least = std::min(least, std::max({0.0, -beyond, beyond - 1.0}));
            }
        }
        return least;
    };
    std::array<std::size_t, 2> best = model_.held_out();
    if (data.segments.size() > 1 || distance(best) >= clear) {
        return false;
    }
    const auto before = best;
    for (std::size_t a = 1; a < 10; a++) {
        for (std::size_t b = a + 2; b < 10; b++) {
            if (distance({a, b}) > distance(best)) {
                best = {a, b};
            }
        }
    }
    model_.hold_out(best);
    return best != before;
}

void block_search::fit_behind_switching()
{
    if (input_.without_switching_fault == nullptr) {
        return;
    }
    std::vector<free_parameter> own;
    std::copy_if(incumbent_.parameters.begin(), incumbent_.parameters.end(), std::back_inserter(own),
                 [](const free_parameter &known) { return known.key->path.substr(0, 6) != "robot."; });
    const noise_model white{{}, noise_.rms, noise_.rms, noise_.rows_per_fact};
    const fit_result settled = fit(model_, white, incumbent_.rig, own, input_.options.replays_max);
    if (settled.cost >= cost_of(model_, white, incumbent_.rig)) {
        return;
    }
    incumbent_.rig = settled.rig;
    const noise_model under = floor_under(model_, incumbent_.rig);
    if (!has_floor_ && under.rms < noise_.rms) {
        noise_ = under;
    }
}

void block_search::fit_without_colour()
{
    if (has_floor_ || !noise_.has_colour()) {
        return;
    }
    const noise_model white{{}, noise_.rms, noise_.rms, noise_.rows_per_fact};
    const fit_result plain = fit(model_, white, incumbent_.rig, incumbent_.parameters, input_.options.replays_max);
    const noise_model under = floor_under(model_, plain.rig);
    if (under.rms < noise_.rms) {
        incumbent_ = plain;
        noise_ = under;
    }
}

void block_search::renew_floor()
{
    constexpr double clearly = 0.8;
    constexpr int rounds_max = 4;
    if (has_floor_ || model_.which() != block::manipulator) {
        return;
    }
    for (int round = 0; round < rounds_max; round++) {
        const noise_model under = floor_under(model_, incumbent_.rig);
        if (under.rms >= clearly * noise_.rms) {
            return;
        }
        noise_ = under;
        incumbent_ = fit(model_, noise_, incumbent_.rig, incumbent_.parameters, input_.options.replays_max);
    }
}

void block_search::start_over_from_given()
{
    if (std::any_of(found_.begin(), found_.end(), [](const effect *one) { return one->is_rough; })) {
        return;
    }
    rig again = given_;
    again.robot.clock = incumbent_.rig.robot.clock;
    for (const effect *const known : found_) {
        for (const effect_parameter &parameter : known->parameters) {
            set_number(again, parameter.key, value_of(incumbent_.rig, parameter.key));
        }
    }
    fit_result other = fit(model_, noise_, again, incumbent_.parameters, input_.options.replays_max);
    if (other.cost < incumbent_.cost) {
        other.rows = incumbent_.rows;
        incumbent_ = std::move(other);
    }
}

void block_search::start_over_from_other_scales()
{
    for (const effect *const known : found_) {
        if (!known->has_minima_by_scale) {
            continue;
        }
        const std::string_view scale = known->parameters.back().key;
        const auto start_over = [&](double value) {
            rig again = incumbent_.rig;
            set_number(again, scale, value);
            /* Between bounds about here: those of the first start may be what the scale is at. */
            const auto parameters = joined(incumbent_.parameters, effect_parameters(*known, again));
            fit_result other = fit(model_, noise_, again, parameters, input_.options.replays_max);
            if (other.cost < incumbent_.cost) {
                other.rows = incumbent_.rows;
                incumbent_ = std::move(other);
            }
        };
        const double found = value_of(incumbent_.rig, scale);
        for (const double factor : {0.1, 0.35, 3.0, 10.0}) {
            start_over(factor * found);
        }
        if (model_.which() == block::manipulator) {
            close_in_on_scale(*known);
        }
    }
}

void block_search::close_in_on_scale(const effect &known)
{
    constexpr int rounds_max = 4;
    constexpr double leads_on = 0.99; /* of the sum of squares */
    const std::string_view scale = known.parameters.back().key;
    const noise_model white{{}, noise_.rms, noise_.rms, noise_.rows_per_fact};
    fit_result best = incumbent_;
    best.cost = cost_of(model_, white, best.rig);
    bool is_better = true;
    for (int round = 0; round < rounds_max && is_better; round++) {
        const fit_result before = best;
        for (const double factor : {0.5, 0.75, 0.9, 1.1, 1.35, 2.0}) {
            rig start = before.rig;
            set_number(start, scale, factor * value_of(before.rig, scale));
            const auto parameters = joined(incumbent_.parameters, effect_parameters(known, start));
            fit_result other = fit(model_, white, start, parameters, input_.options.replays_max / 3);
            if (other.cost < best.cost) {
                best = std::move(other);
            }
        }
        is_better = best.cost < leads_on * before.cost;
    }
    fit_result other = fit(model_, noise_, best.rig, best.parameters, input_.options.replays_max);
    if (other.cost < incumbent_.cost) {
        other.rows = incumbent_.rows;
        incumbent_ = std::move(other);
    }
}

void block_search::drop_stand_ins(block_diagnosis &result)
{
    for (std::size_t i = 0; i + 1 < found_.size();) {
        const effect &dropped = *found_[i];
        const bool is_refined = std::any_of(found_.begin(), found_.end(),
                                            [&](const effect *other) { return other->refines == dropped.name; });
        if (is_refined) {
            i++;
            continue;
        }
        fit_result tried = fit_without(dropped);
        if (bic_of(tried.cost, tried.rows, tried.parameters.size()) >=
            bic_of(incumbent_.cost, incumbent_.rows, incumbent_.parameters.size()) + bic_clear) {
            i++;
            continue;
        }
        incumbent_ = std::move(tried);
        found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(i));
        result.causes.erase(result.causes.begin() + static_cast<std::ptrdiff_t>(i));
    }
}

rig block_search::rig_without(const effect &dropped) const
{
    rig without = incumbent_.rig;
    const std::vector<free_parameter> own = own_parameters();
    for (const effect_parameter &parameter : dropped.parameters) {
        const auto base =
            std::find_if(own.begin(), own.end(), [&](const auto &one) { return one.key->path == parameter.key; });
        const double value = value_of(without, parameter.key);
        set_number(without, parameter.key,
                   base == own.end() ? value_of(given_, parameter.key)
                                     : std::min(std::max(value, base->low), base->high));
    }
    if (dropped.switch_on != nullptr) {
        without.robot.clock = given_.robot.clock;
    }
    return without;
}

fit_result block_search::fit_without(const effect &dropped)
{
    std::vector<free_parameter> parameters;
    std::copy_if(incumbent_.parameters.begin(), incumbent_.parameters.end(), std::back_inserter(parameters),
                 [&](const free_parameter &parameter) {
                     return std::none_of(
                         dropped.parameters.begin(), dropped.parameters.end(),
                         [&](const effect_parameter &gone) { return gone.key == parameter.key->path; });
                 });
    return fit(model_, noise_, rig_without(dropped), joined(own_parameters(), parameters),
               input_.options.replays_max);
}

void block_search::fix_estimates(block_diagnosis &result) const
{
    double precision = 0.0;
    for (const effect *const known : found_) {
        precision = std::max(precision, known->precision);
    }
    for (cause &known : result.causes) {
        if (!known.parameters.empty()) {
            continue;
        }
        known.parameters = estimates(incumbent_, *known.effect, precision);
        /* With a refinement, what the others are beside it: their own causes keep what they were without it. */
        for (const effect *const other : found_) {
            if (is_refining(*known.effect, found_) && !is_refining(*other, found_)) {
                const auto more = estimates(incumbent_, *other, precision);
                known.parameters.insert(known.parameters.end(), more.begin(), more.end());
            }
        }
    }
}

} // namespace berth
