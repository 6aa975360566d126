#include "promise.h"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include "../fit/base.h"
#include "../fit/beginning.h"
#include "../fit/manipulator_regression.h"

namespace berth
{

namespace
{

/* Those that are neither the block's own nor of an effect found in it: a block before has measured them. */
std::vector<bool> are_own(const block_model &model, const fit_result &incumbent, const rig &given,
                          const std::vector<const effect *> &found)
{
    const std::vector<free_parameter> base = base_parameters(model.which(), given);
    std::vector<bool> own;
    for (const free_parameter &one : incumbent.parameters) {
        const auto is_it = [&](const effect_parameter &other) { return other.key == one.key->path; };
        own.push_back(
            std::any_of(base.begin(), base.end(), [&](const auto &other) { return other.key == one.key; }) ||
            std::any_of(found.begin(), found.end(), [&](const effect *known) {
                return std::any_of(known->parameters.begin(), known->parameters.end(), is_it);
            }));
    }
    return own;
}

/* Promises let parameters go where they may not, and what moves the error as one of them does promises nothing:
 * where others were measured in a block before, what is promised with these held; else none. */
std::optional<tangent_space> space_beside_known(const block_model &model, const fit_result &incumbent,
                                                const known_slopes &slopes, const rig &given,
                                                const std::vector<const effect *> &found)
{
    const std::vector<bool> own = are_own(model, incumbent, given, found);
    if (std::find(own.begin(), own.end(), false) == own.end()) {
        return std::nullopt;
    }
    fit_result kept = incumbent;
    kept.parameters.clear();
    known_slopes of_kept;
    std::vector<int> columns;
    for (std::size_t i = 0; i < own.size(); i++) {
        if (own[i]) {
            kept.parameters.push_back(incumbent.parameters[i]);
            of_kept.keys.push_back(slopes.keys[i]);
            columns.push_back(static_cast<int>(i));
        }
    }
    of_kept.white = slopes.white(Eigen::all, columns);
    return tangent_space(kept, of_kept);
}

} // namespace

std::vector<start_point> starts_by_promise(block_model &model, const noise_model &noise, const fit_result &incumbent,
                                           const Eigen::VectorXd &here, const known_slopes &slopes, const rig &given,
                                           const std::vector<const effect *> &found, const search_options &options)
{
    std::vector<double> error;
    model.error(incumbent.rig, error);
    const tangent_space base(incumbent, slopes);
    const tangent_space::target target = base.target_of(here);
    const std::optional<tangent_space> beside_known = space_beside_known(model, incumbent, slopes, given, found);
    const tangent_space::target beside = beside_known ? beside_known->target_of(here) : tangent_space::target{};
    const record_scales scales = scales_of(model, incumbent.rig, error, options);
    beginning first(model, noise, incumbent, slopes, here);
    std::vector<start_point> starts;
    for (const effect *const effect : effects_to_try(model, given, found, options)) {
        if (is_left_out(options, *effect)) {
            continue;
        }
        tell(options, *effect);
        /* The regression's own error is a share of all that pushes: an effect that is less starts as others do, but
         * only beside nothing: beside friction each replay is long. */
        bool is_regressed = false;
        for (const rig &rig : regressed_starts(model, incumbent, found, *effect)) {
            const Eigen::VectorXd change = white_error(model, noise, rig) - here;
            const double promise = base.best_share(target, change, 0.9, 1.1, effect).decrease;
            starts.push_back({effect, rig, promise, false, true});
            is_regressed = is_regressed || promise >= worth_a_fit || !found.empty();
        }
        if (is_regressed) {
            continue;
        }
        std::vector<effect_values> sizes = effect->starts(incumbent.rig, scales);
        if (const auto beyond = base.beyond_bounds(incumbent, target, *effect)) {
            sizes.push_back(*beyond);
        }
        for (const effect_values &values : sizes) {
            start_point start{effect, with_values(incumbent.rig, *effect, values), 0.0, false};
            start.is_hidden =
                options.robot_in_force && effect->block() == "robot" && is_rough_here(*effect, options);
            /* The effect in another size, as far as it is linear in it. */
            const bool is_scaled = effect->is_proportional && values[0] != 0.0;
            /* A manipulator that was computed shows of an effect what is a millionth of its start. */
            const double least = !is_scaled ? 0.1 : model.which() == block::manipulator ? 1e-6 : 1e-3;
            const double most = is_scaled ? 30.0 : 3.0;
            if (!is_scaled && !start.is_hidden && first.rules_out(start.rig, least, most, worth_a_fit)) {
                starts.push_back(std::move(start));
                continue;
            }
            const Eigen::VectorXd change = white_error(model, noise, start.rig) - here;
            const auto [decrease, best] = base.best_share(target, change, least, most, effect);
            start.promise = decrease;
            start.promise_beside_known =
                beside_known ? beside_known->best_share(beside, change, least, most, effect).decrease : 0.0;
            if (is_scaled) {
                set_number(start.rig, effect->parameters[0].key, best * values[0]);
            }
            starts.push_back(std::move(start));
        }
    }
    std::sort(starts.begin(), starts.end(), [](const start_point &a, const start_point &b) {
        return std::tie(a.is_hidden, a.promise) > std::tie(b.is_hidden, b.promise);
    });
    return starts;
}

std::vector<start_point> promising_beside_known(const std::vector<start_point> &starts,
                                                const std::vector<candidate> &fitted)
{
    constexpr double as_much = 0.5;
    std::vector<start_point> best;
    double most = 0.0;
    for (const start_point &start : starts) {
        most = std::max(most, start.promise_beside_known);
        const auto is_of_it = [&](const auto &other) { return other.effect == start.effect; };
        if (std::any_of(fitted.begin(), fitted.end(), is_of_it)) {
            continue;
        }
        const auto same = std::find_if(best.begin(), best.end(), is_of_it);
        if (same == best.end()) {
            best.push_back(start);
        } else if (start.promise_beside_known > same->promise_beside_known) {
            *same = start;
        }
    }
    best.erase(std::remove_if(best.begin(), best.end(),
                              [&](const start_point &one) {
                                  return one.promise_beside_known < std::max(worth_a_fit, as_much * most);
                              }),
               best.end());
    return best;
}

std::vector<start_point> kin_of_fitted(const std::vector<start_point> &starts, const std::vector<candidate> &fitted,
                                       double cost)
{
    constexpr double as_much = 0.5; /* of what the best one explains: the kin of others wins nothing */
    double least_cost = cost;
    for (const candidate &one : fitted) {
        least_cost = std::min(least_cost, one.fitted.cost);
    }
    std::vector<const effect *> of;
    for (const candidate &one : fitted) {
        if (cost - one.fitted.cost > as_much * (cost - least_cost)) {
            of.push_back(one.effect);
        }
    }
    std::vector<start_point> kin;
    for (std::size_t i = 0; i < of.size(); i++) {
        for (const start_point &start : starts) {
            const effect &other = *start.effect;
            const auto is_it = [&](const auto &known) { return known.effect == &other; };
            const bool is_kin = of[i]->generalises == other.name || of[i]->look_alike == other.name ||
                                other.look_alike == of[i]->name;
            if (is_kin && std::none_of(fitted.begin(), fitted.end(), is_it) &&
                std::none_of(kin.begin(), kin.end(), is_it)) {
                of.push_back(&other);
                kin.push_back(start);
            }
        }
    }
    return kin;
}

} // namespace berth
