#include "search.h"

#include <algorithm>
#include <cmath>

#include "../fit/manipulator_regression.h"
#include "../fit/progressive_fit.h"
#include "../fit/response.h"
#include "promise.h"

namespace berth
{

double width_of_size(block_model &model, const noise_model &noise, const fit_result &fitted, std::string_view key)
{
    constexpr double certain = 3.84; /* 19 times in 20 */
    const double size = value_of(fitted.rig, key);
    const double cost = cost_of(model, noise, fitted.rig);
    double share = 0.0;
    for (int i = 0; i < 20; i++) { /* up to a fifth */
        share = 1e-4 * std::pow(1.5, i);
        double least_rise = unlimited;
        for (const double sign : {-1.0, 1.0}) {
            rig moved = fitted.rig;
            set_number(moved, key, size * (1.0 + sign * share));
            least_rise = std::min(least_rise, cost_of(model, noise, moved) - cost);
        }
        if (least_rise > certain * std::max(1.0, cost / static_cast<double>(fitted.rows))) {
            break;
        }
    }
    return size * share;
}

fit_result fit_rough(block_model &model, const noise_model &noise, const effect &effect, const rig &start,
                     const fit_result &incumbent, const search_options &options, double factor)
{
    const std::string_view key = effect.parameters[0].key;
    double best = value_of(start, key);
    constexpr int rounds = 9; /* to 2e-4 of the size: each of a thousand switchings then falls into its tick */
    fit_result fitted;
    fitted.rig = start;
    double cost = cost_of(model, noise, start);
    for (int round = 0; round < rounds; round++) {
        const double middle = best;
        for (const double place : {-0.8, -0.6, -0.4, -0.2, 0.2, 0.4, 0.6, 0.8}) {
            rig tried = fitted.rig;
            set_number(tried, key, middle * std::pow(factor, place));
            const double tried_cost = cost_of(model, noise, tried);
            if (tried_cost < cost) {
                cost = tried_cost;
                best = value_of(tried, key);
            }
        }
        set_number(fitted.rig, key, best);
        fitted = fit(model, noise, fitted.rig, incumbent.parameters, options.replays_max / 3);
        cost = fitted.cost;
        factor = std::pow(factor, 0.4);
    }
    fitted.parameters.push_back({find_key(key), 0.5 * best, 2.0 * best});
    fitted.ci95.push_back(width_of_size(model, noise, fitted, key));
    return fitted;
}

namespace
{

bool is_at_floor(const fit_result &fitted)
{
    constexpr double near = 1.2; /* times the white sum of squares that the noise has */
    return fitted.cost < near * static_cast<double>(fitted.rows);
}

/* Fitted from the values that are expected with sizes of `effect` about the one `found`: the best. */
fit_result fit_from_sizes_about(block_model &model, const noise_model &noise, const effect &effect, const rig &found,
                                const std::vector<free_parameter> &parameters, const search_options &options)
{
    const std::string_view key = effect.parameters[0].key;
    fit_result best;
    best.cost = unlimited;
    for (const double factor : {0.88, 0.91, 0.94, 0.97, 1.03, 1.06, 1.09, 1.12}) {
        rig tried = found;
        for (const free_parameter &known : parameters) {
            if (known.expected_sd < unlimited) {
                set_number(tried, known.key->path, known.expected);
            }
        }
        set_number(tried, key, factor * value_of(found, key));
        fit_result fitted = fit(model, noise, tried, parameters, options.replays_max / 2);
        if (fitted.cost < best.cost) {
            best = std::move(fitted);
        }
    }
    return best;
}

std::vector<rig> rigs_of(const std::vector<start_point> &starts, const effect &effect)
{
    std::vector<rig> rigs;
    for (const start_point &start : starts) {
        if (start.effect == &effect) {
            rigs.push_back(start.rig);
        }
    }
    return rigs;
}

/* The most promising start, or where the beginning of the record leads from all of them. */
rig rough_start(block_model &model, const noise_model &noise, const start_point &best,
                const std::vector<start_point> &starts, const fit_result &incumbent, const search_options &options)
{
    if (!best.effect->acts_at_once) {
        return best.rig;
    }
    const auto led = size_on_growing_horizon(model, noise, *best.effect, incumbent.rig, incumbent.parameters,
                                             rigs_of(starts, *best.effect), options.replays_max / 6);
    return led ? *led : best.rig;
}

/* How many times larger or smaller the next start of this effect is. */
double spacing_about(const start_point &at, const std::vector<start_point> &starts)
{
    constexpr double least = 1.02;
    constexpr double most = 1.3;
    const std::string_view key = at.effect->parameters[0].key;
    const double size = std::abs(value_of(at.rig, key));
    double larger = unlimited;
    double smaller = unlimited;
    for (const start_point &other : starts) {
        const double ratio = std::abs(value_of(other.rig, key)) / size;
        if (other.effect == at.effect && ratio > 1.0) {
            larger = std::min(larger, ratio);
        } else if (other.effect == at.effect && ratio < 1.0) {
            smaller = std::min(smaller, 1.0 / ratio);
        }
    }
    const double spacing = std::max(larger < unlimited ? larger : 0.0, smaller < unlimited ? smaller : 0.0);
    return std::clamp(spacing, least, most);
}

} // namespace

fit_result fit_what_decides(block_model &model, const noise_model &noise, const effect &effect,
                            const fit_result &incumbent, const std::vector<rig> &starts,
                            const search_options &options)
{
    constexpr double hardly_less = 0.8; /* of the sum of squares */
    fit_result found =
        fit_progressively(model, noise, effect, incumbent.rig, incumbent.parameters, starts, options.replays_max);
    if (found.cost > hardly_less * incumbent.cost) {
        return found;
    }
    const fit_result best = fit_from_sizes_about(model, noise, effect, found.rig, incumbent.parameters, options);
    fit_result other = fit(model, noise, best.rig, found.parameters, options.replays_max);
    return other.cost < found.cost ? other : found;
}

void tell(const search_options &options, const effect &effect)
{
    if (options.tell) {
        options.tell(effect);
    }
}

bool is_left_out(const search_options &options, const effect &effect)
{
    if (!options.limit || !options.limit->is_over()) {
        return false;
    }
    options.limit->leave_out(effect.name);
    return true;
}

bool is_rough_here(const effect &effect, const search_options &options)
{
    return effect.is_rough || (options.robot_in_force && effect.switches && effect.block() == "robot");
}

bool is_refining(const effect &effect, const std::vector<const berth::effect *> &found)
{
    return !effect.refines.empty() &&
           std::find(found.begin(), found.end(), find_effect(effect.refines)) != found.end();
}

namespace
{

/* What was found has its size among its own parameters. */
bool is_contained(const effect &effect, const std::vector<const berth::effect *> &found)
{
    const auto has_its_size = [&](const berth::effect *one) {
        return std::any_of(one->parameters.begin(), one->parameters.end(),
                           [&](const effect_parameter &own) { return own.key == effect.parameters.front().key; });
    };
    return std::any_of(found.begin(), found.end(), has_its_size);
}

} // namespace

bool is_tried(const effect &effect, block_model &model, const rig &given,
              const std::vector<const berth::effect *> &found, const search_options &options)
{
    const bool is_hidden_robot = options.robot_in_force && model.which() == block::force && effect.hides_in_reports;
    return !effect.is_of_single_samples && effect.starts != nullptr &&
           (options.decider == nullptr || effect.is_of_time_alone || effect.block() == "sensor") &&
           (is_hidden_robot || acts_in(effect, model.which(), model.data(), given)) &&
           !is_contained(effect, found) &&
           std::find(options.without.begin(), options.without.end(), effect.name) == options.without.end();
}

std::vector<const effect *> effects_to_try(block_model &model, const rig &given,
                                           const std::vector<const effect *> &found, const search_options &options)
{
    std::vector<const effect *> tried;
    for (const effect &effect : effect_library()) {
        if (is_tried(effect, model, given, found, options) && !is_left_out(options, effect)) {
            tried.push_back(&effect);
        }
    }
    return tried;
}

fit_result fit_effect(block_model &model, const noise_model &noise, const effect &effect, const fit_result &found,
                      const fit_result &incumbent, const search_options &options)
{
    tell(options, effect);
    return is_rough_here(effect, options) ? fit_rough(model, noise, effect, found.rig, incumbent, options)
                                          : fit(model, noise, found.rig, found.parameters, options.replays_max);
}

double bic_of(double cost, std::size_t rows, std::size_t parameters)
{
    const double count = static_cast<double>(std::max<std::size_t>(rows, 1));
    return count * std::log(std::max(cost, 1e-300) / count) + static_cast<double>(parameters) * std::log(count);
}

namespace
{

/* A base parameter of the effect's own has gone as far as its tolerance allows. Promises tell such an effect badly
 * from others: they let the other parameters of the base go where they may not. */
bool is_held_by_tolerance(const effect &effect, const fit_result &incumbent)
{
    constexpr double near = 0.01; /* of the way between the bounds */
    return std::any_of(incumbent.parameters.begin(), incumbent.parameters.end(), [&](const free_parameter &known) {
        const auto is_own = [&](const effect_parameter &own) { return own.key == known.key->path; };
        const double place = (value_of(incumbent.rig, known.key->path) - known.low) / (known.high - known.low);
        return known.expected_sd < unlimited && (place < near || place > 1.0 - near) &&
               std::any_of(effect.parameters.begin(), effect.parameters.end(), is_own);
    });
}

/* The best candidates beside an effect that decides what follows, with its size looked for anew: what was missing
 * had led it astray. */
void decide_anew(block_model &model, const noise_model &noise, std::vector<candidate> &candidates,
                 const search_options &options)
{
    constexpr std::size_t count_max = 3;
    constexpr double about = 1.2; /* the size that was found */
    constexpr double nearer = 1.05;
    const std::string_view key = options.decider->parameters[0].key;
    for (std::size_t i = 0; i < std::min(count_max, candidates.size()); i++) {
        candidate &one = candidates[i];
        fit_result others = one.fitted;
        others.parameters.erase(std::remove_if(others.parameters.begin(), others.parameters.end(),
                                               [&](const auto &known) { return known.key->path == key; }),
                                others.parameters.end());
        fit_result anew = fit_rough(model, noise, *options.decider, one.fitted.rig, others, options, about);
        if (!is_at_floor(anew)) {
            const fit_result best =
                fit_from_sizes_about(model, noise, *options.decider, anew.rig, others.parameters, options);
            fit_result other = fit_rough(model, noise, *options.decider, best.rig, others, options, nearer);
            anew = other.cost < anew.cost ? std::move(other) : std::move(anew);
        }
        if (anew.cost < one.fitted.cost) {
            one.fitted = std::move(anew);
            one.white_cost = one.fitted.cost;
            one.bic = bic_of(one.fitted.cost, one.fitted.rows, one.fitted.parameters.size());
        }
    }
}

void sort_by_bic(std::vector<candidate> &candidates)
{
    std::sort(candidates.begin(), candidates.end(),
              [](const candidate &a, const candidate &b) { return a.bic < b.bic; });
}

} // namespace

void drop_diverged(std::vector<candidate> &candidates)
{
    candidates.erase(std::remove_if(candidates.begin(), candidates.end(),
                                    [](const candidate &one) { return !std::isfinite(one.bic); }),
                     candidates.end());
}

std::vector<candidate> search_effects(block_model &model, const noise_model &noise, const fit_result &incumbent,
                                      const rig &given, const std::vector<const effect *> &found,
                                      const search_options &options)
{
    const Eigen::VectorXd here = white_error(model, noise, incumbent.rig);
    const known_slopes slopes = slopes_at(model, noise, incumbent, here);
    const std::vector<start_point> starts =
        starts_by_promise(model, noise, incumbent, here, slopes, given, found, options);

    const auto rated = [&](const start_point &start, fit_result fitted) {
        candidate made;
        made.effect = start.effect;
        made.fitted = std::move(fitted);
        made.white_cost = made.fitted.cost;
        made.bic = bic_of(made.fitted.cost, made.fitted.rows, made.fitted.parameters.size());
        return made;
    };
    const auto decided_from = [&](const start_point &start) {
        tell(options, *start.effect);
        return rated(start, fit_what_decides(model, noise, *start.effect, incumbent, rigs_of(starts, *start.effect),
                                             options));
    };
    const auto fitted_from = [&](const start_point &start) {
        tell(options, *start.effect);
        if (is_rough_here(*start.effect, options)) {
            return rated(start, fit_rough(model, noise, *start.effect,
                                          rough_start(model, noise, start, starts, incumbent, options), incumbent,
                                          options, start.effect->acts_at_once ? 1.3 : spacing_about(start, starts)));
        }
        const auto parameters = start.is_regressed
                                    ? parameters_about(start.rig, incumbent, found, *start.effect)
                                    : joined(incumbent.parameters, effect_parameters(*start.effect, start.rig));
        return rated(start, fit(model, noise, start.rig, parameters, options.replays_max,
                                start.is_regressed ? nullptr : &slopes));
    };
    std::vector<candidate> candidates;
    int tried = 0;
    for (const start_point &start : starts) {
        const auto same = std::count_if(candidates.begin(), candidates.end(),
                                        [&](const candidate &known) { return known.effect == start.effect; });
        if (same >= start.effect->fits_max) {
            continue;
        }
        if (start.promise < worth_a_fit && !start.is_hidden) {
            break;
        }
        if (is_left_out(options, *start.effect)) {
            continue;
        }
        if (tried >= options.fits_max && !is_held_by_tolerance(*start.effect, incumbent)) {
            continue;
        }
        candidates.push_back(same == 0 && start.effect->decides_what_follows ? decided_from(start)
                                                                             : fitted_from(start));
        tried += same == 0;
    }
    for (const start_point &start : promising_beside_known(starts, candidates)) {
        candidates.push_back(fitted_from(start));
    }
    for (const start_point &start : kin_of_fitted(starts, candidates, here.squaredNorm())) {
        candidates.push_back(fitted_from(start));
    }
    drop_diverged(candidates);
    sort_by_bic(candidates);
    if (options.decider != nullptr) {
        decide_anew(model, noise, candidates, options);
        drop_diverged(candidates);
        sort_by_bic(candidates);
    }
    /* Of two fits of one effect the better stays. */
    std::vector<candidate> best;
    for (candidate &made : candidates) {
        const bool is_there = std::any_of(best.begin(), best.end(),
                                          [&](const candidate &known) { return known.effect == made.effect; });
        if (!is_there) {
            best.push_back(std::move(made));
        }
    }
    return best;
}

} // namespace berth
