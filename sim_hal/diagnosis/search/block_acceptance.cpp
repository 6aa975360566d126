#include <algorithm>
#include <cmath>
#include <Eigen/Core>

#include "../../effects/active.h"
#include "../../solver/decompositions.h"
#include "../fit/response.h"
#include "../noise/floor.h"
#include "../noise/spectrum_lines.h"
#include "acceptance.h"
#include "block_search.h"

namespace berth
{

namespace
{

/* At most all: a floor is not known to the last digit. None where nothing can be explained. */
double share_of(double explained, double explainable)
{
    constexpr double one_row = 1.0;
    return explainable < one_row ? 0.0 : std::min(1.0, explained / explainable);
}

constexpr double bic_unseen = 60.0; /* the same as bic_clear where nothing is left above the noise */

/* Share of the decrease that BIC asks for: what the first look has below it does not reach it. In 34 hidden records
 * the full fit of such candidates reached half of it at most. */
constexpr double hopeless = 0.4;

constexpr double of_unseen_least = 0.25;       /* of what is little beside the first effect */
constexpr double share_of_precision = 1e-5;    /* of the whole explainable error: our own precision */
constexpr double share_of_linear_robot = 1e-7; /* the same where nothing switches, rubs or bends */
/* Of the whole explainable error: less may be the first effect's own finer ways. */
constexpr double share_of_all = 0.02;
/* What explains half of what is left, beyond any doubt, is no finer way: of a real servo its lag and dead time
 * beside its velocity limit. */
constexpr double share_of_all_clear = 0.002;
constexpr double share_clear = 0.5;
constexpr double share_of_all_refining = 0.003;

/* Whether `best` is what `other` contains, and all that this record shows of it: what the further parameters improve
 * is no more than chance improves 19 times in 20. */
bool is_enough(const candidate &best, const candidate &other)
{
    constexpr double by_chance = 3.84;
    const double improved = best.fitted.cost - other.fitted.cost;
    return other.effect->generalises == best.effect->name && improved < by_chance;
}

/* A robot that small motions have as it is is replayed to the last digits. */
bool is_linear_robot(block block, const rig &rig)
{
    const bool is_limited =
        rig.robot.velocity_limit_m_per_s != unlimited || rig.robot.acceleration_limit_m_per_s2 != unlimited;
    return block == block::robot && !is_limited && left_out_when_small(rig).empty();
}

bool size_may_be_zero(const candidate &one)
{
    constexpr double certain = 1.5; /* times the interval */
    for (std::size_t i = 0; i < one.fitted.ci95.size(); i++) {
        for (std::size_t j = 0; j < one.effect->sizes; j++) {
            const std::string_view key = one.effect->parameters[j].key;
            if (one.fitted.parameters[i].key->path == key &&
                std::abs(value_of(one.fitted.rig, key)) < certain * one.fitted.ci95[i]) {
                return true;
            }
        }
    }
    return false;
}

} // namespace

bool block_search::find_next(block_diagnosis &result)
{
    doubt_floor();
    metric_ = metric_for(incumbent_.rig);
    if (found_.empty()) {
        result.tried = effects_to_try(model_, given_, found_, input_.options);
    }
    search_options options = input_.options;
    options.decider = !found_.empty() && found_.back()->decides_what_follows ? found_.back() : nullptr;
    std::vector<candidate> candidates = search_effects(model_, metric_, incumbent_, given_, found_, options);
    if (candidates.empty()) {
        return false;
    }
    compare_anew(candidates);
    drop_those_unseen(candidates);
    if (candidates.empty()) {
        return false;
    }
    fit_incumbent_from(candidates.front());
    retuned_ = found_.empty() ? incumbent_.rig : retuned_;
    incumbent_.cost = cost_of(model_, metric_, incumbent_.rig);
    incumbent_.rows = rows_under(metric_);
    std::vector<double> error;
    model_.error(incumbent_.rig, error);
    leftover_ = find_leftover(model_, metric_, incumbent_.rig, error);
    const double bic_before = bic_of(incumbent_.cost, incumbent_.rows, incumbent_.parameters.size());
    const double explainable = excess(incumbent_.cost, incumbent_.rows);
    for (const candidate &one : candidates) {
        result.ranking.push_back({static_cast<int>(found_.size()) + 1, one.effect, bic_before - one.bic,
                                  share_of(incumbent_.cost - one.fitted.cost, explainable), one.fitted});
    }
    /* What refines an effect found before has to wait until nothing else is to be found; the last place is its own
     * if it explains all that is left. */
    std::stable_partition(candidates.begin(), candidates.end(),
                          [&](const candidate &one) { return !is_refining(*one.effect, found_); });
    const auto refining = std::find_if(candidates.begin(), candidates.end(),
                                       [&](const candidate &one) { return is_refining(*one.effect, found_); });
    const bool is_last = static_cast<int>(found_.size()) + 1 == input_.effects_max;
    const bool is_the_rest = is_last && refining != candidates.end() &&
                             refining->bic < candidates.front().bic - bic_look_alike &&
                             incumbent_.cost - refining->fitted.cost > share_of_rest * explainable;
    const auto others = candidates.begin();
    for (auto first : {is_the_rest ? refining : others, is_the_rest ? others : refining}) {
        if (first != candidates.end() && accept(result, candidates, *first, bic_before, explainable)) {
            return true;
        }
    }
    return false;
}

void block_search::doubt_floor()
{
    constexpr double near = 1.5; /* times the floor */
    const std::vector<double> left = error_left();
    if (has_floor_ && rms_of(left, model_.uses(), row_use::fit) < near * noise_.rms && has_line(left)) {
        has_floor_ = false;
        noise_ = floor_under(model_, incumbent_.rig);
    }
}

void block_search::compare_anew(std::vector<candidate> &candidates)
{
    if (!has_floor_) {
        const noise_model smaller = floor_under(model_, candidates.front().fitted.rig);
        if (smaller.rms < noise_.rms) {
            noise_ = smaller;
        }
    }
    metric_ = metric_for(candidates.front().fitted.rig);
    const double before = cost_of(model_, metric_, incumbent_.rig);
    for (std::size_t i = 0; i < candidates.size(); i++) {
        candidate &one = candidates[i];
        one.fitted.cost = cost_of(model_, metric_, one.fitted.rig);
        const double better = before - one.fitted.cost;
        const double more =
            static_cast<double>(one.fitted.parameters.size()) - static_cast<double>(incumbent_.parameters.size());
        const double asked = bic_clear + more * std::log(static_cast<double>(rows_under(metric_)));
        const bool is_hopeless = better >= 0.0 && better < hopeless * asked;
        if (i < 3 && !one.effect->is_rough && !is_hopeless) {
            one.fitted = fit(model_, metric_, one.fitted.rig, one.fitted.parameters, input_.options.replays_max);
        }
        one.fitted.rows = rows_under(metric_);
        one.bic = bic_of(one.fitted.cost, one.fitted.rows, one.fitted.parameters.size());
    }
    drop_diverged(candidates);
    std::sort(candidates.begin(), candidates.end(),
              [](const candidate &a, const candidate &b) { return a.bic < b.bic; });
}

void block_search::fit_incumbent_from(const candidate &best)
{
    if (std::any_of(found_.begin(), found_.end(), [](const effect *one) { return one->is_rough; })) {
        return; /* slopes mean nothing there */
    }
    rig again = incumbent_.rig;
    for (const free_parameter &known : incumbent_.parameters) {
        set_number(again, known.key->path, value_of(best.fitted.rig, known.key->path));
    }
    fit_result other = fit(model_, metric_, again, incumbent_.parameters, input_.options.replays_max);
    if (other.cost < cost_of(model_, metric_, incumbent_.rig)) {
        incumbent_ = std::move(other);
    }
}

void block_search::drop_those_unseen(std::vector<candidate> &candidates)
{
    std::vector<double> error;
    model_.error(incumbent_.rig, error);
    const record_scales scales = scales_of(model_, incumbent_.rig, error, input_.options);
    const auto is_none = [&](const candidate &one) {
        const bool is_seen = one.effect->is_seen == nullptr || one.effect->is_seen(one.fitted.rig, scales) ||
                             (one.effect->is_curve && is_no_plain_curve(one));
        return size_may_be_zero(one) || !is_seen;
    };
    candidates.erase(std::remove_if(candidates.begin(), candidates.end(), is_none), candidates.end());
}

bool block_search::is_no_plain_curve(const candidate &one)
{
    constexpr int degree = 4;
    constexpr double clear = 12.0; /* of the white sum of squares, and with two parameters less */
    if (model_.which() != block::robot) {
        return false;
    }
    const Eigen::VectorXd left = white_error(model_, metric_, incumbent_.rig);
    const known_slopes slopes = slopes_at(model_, metric_, incumbent_, left);
    std::vector<double> error;
    model_.error(incumbent_.rig, error); /* and the motion with it */
    const std::vector<double> &place = model_.motion().at_tick_m;
    const auto [least, most] = std::minmax_element(place.begin(), place.end());
    const double middle_m = 0.5 * (*least + *most);
    const double half_m = std::max(0.5 * (*most - *least), 1e-300);
    Eigen::MatrixXd curves(left.size(), slopes.white.cols() + degree + 1);
    curves.leftCols(slopes.white.cols()) = slopes.white;
    std::vector<double> power(place.size(), 1.0);
    std::vector<double> white;
    for (int i = 0; i <= degree; i++) {
        whiten(metric_, power, model_.uses(), row_use::fit, white);
        curves.col(slopes.white.cols() + i) = Eigen::Map<const Eigen::VectorXd>(white.data(), left.size());
        for (std::size_t n = 0; n < place.size(); n++) {
            power[n] *= (place[n] - middle_m) / half_m;
        }
    }
    const Eigen::VectorXd shares = least_squares_solution(curves, left);
    return (left - curves * shares).squaredNorm() - one.fitted.cost > clear;
}

double block_search::improvement(const candidate &best, double bic_before) const
{
    return std::min(bic_before - best.bic, incumbent_.cost - best.fitted.cost);
}

/* Of one that swings by itself; a motion of one frequency has lines of its own there in what a cause leaves. */
bool block_search::is_harmonic_of_motion(const candidate &one) const
{
    constexpr double harmonics_max = 12.0;
    constexpr double lines_apart = 2.0; /* of the record's own */
    const record &data = model_.data();
    const double motion_Hz = strongest_frequency_Hz(data.command_position_m, data.period_s);
    const double frequency_Hz = value_of(one.fitted.rig, "sensor.periodic_frequency_Hz");
    const double ratio = std::max(1.0, std::round(frequency_Hz / std::max(motion_Hz, 1e-9)));
    const double line_Hz = 1.0 / (data.period_s * static_cast<double>(data.size()));
    return ratio < harmonics_max && std::abs(frequency_Hz - ratio * motion_Hz) < lines_apart * ratio * line_Hz;
}

double block_search::share_of_all_asked(const candidate &best, double share, bool is_clear) const
{
    constexpr double at_floor = 1.05; /* of the white sum of squares that the noise has */
    const bool is_nearly_all = share > share_of_rest;
    if (is_refining(*best.effect, found_)) {
        return is_nearly_all ? share_of_precision : share_of_all_refining;
    }
    if (!is_clear) {
        return share_of_all;
    }
    const bool is_linear = is_linear_robot(model_.which(), best.fitted.rig);
    const bool is_at_floor = best.fitted.cost < at_floor * static_cast<double>(best.fitted.rows);
    /* The base's own parameters beyond their tolerances make up for how else an effect acts than ours does, as
     * damping does for a friction that falls with velocity. */
    const std::string_view name = best.effect->name;
    const bool is_of_base = (name == "object.parameters" || name == "manipulator.parameters") &&
                            std::any_of(found_.begin(), found_.end(),
                                        [&](const effect *known) { return known->block() == best.effect->block(); });
    const bool is_no_finer_way = ((is_nearly_all || is_linear) && is_at_floor && !is_of_base) ||
                                 (best.effect->is_of_time_alone && !is_harmonic_of_motion(best));
    return !is_no_finer_way ? share_of_all_clear : is_linear ? share_of_linear_robot : share_of_precision;
}

/* BIC: what smooths a command that was rounded takes the rounding out of the error, whatever the robot did. */
double block_search::won_by_smoothing(const effect &best, const effect &other) const
{
    const auto smooths = [](const effect &one) { return one.name == "robot.lag" || one.name == "robot.resonance"; };
    if (input_steps_rms_ == 0.0 || !smooths(best) || smooths(other)) {
        return 0.0;
    }
    return static_cast<double>(incumbent_.rows) * std::log1p(std::pow(input_steps_rms_ / noise_.rms, 2));
}

bool block_search::is_worthwhile(const candidate &best, double better, double share, double of_all) const
{
    const bool is_clear = share > share_clear && better > bic_beyond_doubt;
    const bool is_above_floor = incumbent_.cost > static_cast<double>(incumbent_.rows);
    /* What a fault that switches upstream may leave is believed to be more only if that explains nearly all of it.
     */
    const double share_least = is_rest_ ? share_of_rest : share_worthwhile;
    return better >= (is_above_floor ? bic_clear : bic_unseen) && share >= share_least &&
           of_all >= share_of_all_asked(best, share, is_clear);
}

bool block_search::may_be_shown_by_unseen(const candidate &best, double better, double share, double of_all) const
{
    return unseen_ != nullptr && !is_rest_ && !is_refining(*best.effect, found_) && better >= bic_unseen &&
           share >= share_worthwhile && of_all >= share_of_all_clear;
}

bool block_search::leaves_nothing_that_depends(const candidate &best)
{
    constexpr double hardly = 0.02; /* of what depended on state or time before */
    std::vector<double> error;
    model_.error(best.fitted.rig, error);
    const leftover after = find_leftover(model_, metric_, best.fitted.rig, error);
    return after.share_of_rms * best.fitted.cost < hardly * leftover_.share_of_rms * incumbent_.cost;
}

bool block_search::makes_error_larger(const candidate &best)
{
    constexpr double clearly = 1.05; /* times: what slow noise is off by may be a little more */
    std::vector<double> error;
    model_.error(best.fitted.rig, error);
    return rms_of(error, model_.uses(), row_use::fit) > clearly * rms_of(error_left(), model_.uses(), row_use::fit);
}

bool block_search::accept(block_diagnosis &result, const std::vector<candidate> &candidates, const candidate &best,
                          double bic_before, double explainable)
{
    double share = (incumbent_.cost - best.fitted.cost) / explainable;
    const double better = improvement(best, bic_before);
    const bool all_hangs_on_one = !found_.empty() && found_.back()->decides_what_follows;
    if (share > share_worthwhile && share < share_of_rest && better > bic_beyond_doubt && !all_hangs_on_one &&
        leaves_nothing_that_depends(best)) {
        share = 1.0; /* a floor that was found in the error has part of it */
    }
    const double of_all =
        (incumbent_.cost - best.fitted.cost) /
        std::max(1e-9, cost_of(model_, metric_, base_.rig) - static_cast<double>(rows_under(metric_)));
    gain gained{}; /* fits on parts of the record: only for what else speaks for */
    double asked = held_out_least;
    if (makes_error_larger(best)) {
        asked = 1.0;
    } else if (is_worthwhile(best, better, share, of_all)) {
        gained = gain_of(best, share > share_of_rest && better > bic_unseen);
    } else if (may_be_shown_by_unseen(best, better, share, of_all)) {
        gained = gain_on_unseen(best);
        asked = of_unseen_least;
    }
    if (gained.low <= 0.0 || gained.of_explainable < asked) {
        const bool is_little = of_all < left_full && !exceeds_uncertainty(incumbent_.cost);
        is_suspect_ = is_suspect_ || (better > bic_suspect && of_all > share_of_precision && !is_little &&
                                      is_better_throughout(best));
        if (is_suspect_ && share > share_worthwhile) {
            result.alternatives.push_back({best.effect, best.bic - bic_before});
        }
        return false;
    }
    is_suspect_ = false;
    if (is_refining(*best.effect, found_)) {
        fix_estimates(result); /* a refinement shares out anew what they explain */
    }
    cause made;
    made.effect = best.effect;
    made.delta_bic = bic_before - best.bic;
    made.share_explained = std::min(1.0, share);
    made.held_out_gain = gained.value;
    made.held_out_gain_low = gained.low;
    made.held_out_gain_high = gained.high;
    result.causes.push_back(made);
    found_.push_back(best.effect);
    for (const candidate &other : candidates) {
        const double distance = other.bic - best.bic;
        const bool is_look_alike = other.effect->look_alike == best.effect->name;
        const double undecided =
            (is_look_alike ? bic_look_alike : bic_undecided) + won_by_smoothing(*best.effect, *other.effect);
        if (&other != &best && distance < undecided &&
            is_refining(*other.effect, found_) == is_refining(*best.effect, found_) && !is_enough(best, other)) {
            result.alternatives.push_back({other.effect, distance});
        }
    }
    adopt(result, best);
    return true;
}

} // namespace berth
