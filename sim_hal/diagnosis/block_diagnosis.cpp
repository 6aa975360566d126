#include "block_diagnosis.h"

#include <algorithm>
#include <cmath>

#include "acceptance.h"
#include "floor.h"
#include "gain.h"
#include "moments.h"
#include "single_samples.h"

namespace berth
{

namespace
{

/* Improvements of the white sum of squares by features with no meaning stay far below this. */
constexpr double leftover_significant = 30.0;

constexpr double moments_bearable = 0.04;
constexpr double bic_suspect = 40.0;    /* so much better, and yet no cause: something else is there */
constexpr double held_out_least = 0.05; /* share of the explainable error that an effect explains on unseen data */
constexpr double left_full = 0.003;     /* share of it that may be left of a full explanation: our own precision */
constexpr double share_of_precision = 1e-5; /* the same where an effect points it out */
constexpr double floor_exceeded = 1.21;     /* white sum of squares per row: 1.1 times the floor */

constexpr double bursts_exceed = 1.5;    /* the same against a floor that was not measured by itself */
constexpr double share_of_replay = 1e-4; /* of the explained error, that may be the replay's own */

constexpr double share_of_all =
    0.02; /* of the whole explainable error: less may be the first effect's own finer ways */
constexpr double share_of_all_refining = 0.003;

std::vector<parameter_estimate> estimates(const fit_result &fitted, const effect &effect)
{
    std::vector<parameter_estimate> all;
    for (const effect_parameter &parameter : effect.parameters) {
        double ci95 = 0.0;
        for (std::size_t i = 0; i < fitted.parameters.size() && i < fitted.ci95.size(); i++) {
            if (fitted.parameters[i].key->path == parameter.key) {
                ci95 = fitted.ci95[i];
            }
        }
        all.push_back({std::string(parameter.key), value_of(fitted.rig, parameter.key), ci95});
    }
    return all;
}

/* It has no size of its own: its whole turn is. */
bool is_angle(const free_parameter &parameter)
{
    const std::string_view path = parameter.key->path;
    return path.size() > 4 && path.substr(path.size() - 4) == "_rad";
}

/* An effect of no size is none, whatever its other parameters make up for. */
bool size_may_be_zero(const candidate &one)
{
    const std::string_view key = one.effect->parameters[0].key;
    const bool has_size = one.effect->switch_on != nullptr;
    for (std::size_t i = 0; has_size && i < one.fitted.ci95.size(); i++) {
        if (one.fitted.parameters[i].key->path == key) {
            return std::abs(value_of(one.fitted.rig, key)) < 1.5 * one.fitted.ci95[i];
        }
    }
    return false;
}

class block_search
{
  public:
    block_search(block block, const diagnosis_input &input, const rig &given, const sample_events &events)
        : input_(input), given_(given), events_(events),
          model_(block, *input.fit, given, events,
                 input.validation == nullptr ? held_out_parts::two_tenths : held_out_parts::none)
    {
        if (input.validation != nullptr) {
            unseen_ =
                std::make_unique<block_model>(block, *input.validation, given, no_events_, held_out_parts::none);
        }
    }

    block_model &model() { return model_; }

    void run(block_diagnosis &result)
    {
        model_.error(given_, result.error_before);
        fit_base();
        base_ = incumbent_;
        rate_base(result);
        is_rest_ = is_rest_of_switching();
        for (int round = 0; round < input_.effects_max && !is_rest_; round++) {
            if (!find_next(result)) {
                break;
            }
        }
        conclude(result);
    }

  private:
    /* The base model's, and those of the robot before it as far as its own channel left them open. */
    std::vector<free_parameter> own_parameters() const
    {
        return joined(input_.upstream, base_parameters(model_.which(), given_));
    }

    void fit_base()
    {
        const auto parameters = own_parameters();
        std::vector<double> error;
        model_.error(given_, error);
        const bool has_measured = input_.floor && model_.rows_per_fact() == 1.0;
        noise_ = has_measured ? *input_.floor : noise_of(model_, error, true);
        incumbent_ = fit(model_, noise_, given_, parameters, input_.options.base_replays_max);
        const noise_model under = floor_under(model_, incumbent_.rig);
        /* Runs that repeat a command need not repeat what came of it: a floor above the error itself is none. */
        has_floor_ = has_measured && input_.floor->rms < 1.25 * under.rms;
        if (!has_floor_) {
            noise_ = under;
            incumbent_ = fit(model_, noise_, incumbent_.rig, parameters, input_.options.base_replays_max);
        }
    }

    void rate_base(block_diagnosis &result)
    {
        std::vector<double> error;
        model_.error(incumbent_.rig, error);
        leftover_ = find_leftover(model_, noise_, incumbent_.rig, error);
        result.explainable = excess(incumbent_.cost, incumbent_.rows);
    }

    /* White sum of squares above the floor. */
    double excess(double cost, std::size_t rows) const
    {
        /* A floor that was found in the error itself, blind to what is unusual, is a little low. */
        const double blindness = has_floor_ ? 0.0 : 0.04;
        return std::max({cost - (1.0 + blindness) * static_cast<double>(rows), leftover_.explained, 1e-9});
    }

    bool exceeds_measured_floor() const
    {
        return has_floor_ && incumbent_.cost > floor_exceeded * static_cast<double>(incumbent_.rows);
    }

    /* Far above a floor that was found without it, and more than our own precision of what was explained. */
    bool exceeds_floor()
    {
        const double rows = static_cast<double>(rows_under(noise_));
        const double above = cost_of(model_, noise_, incumbent_.rig) - rows;
        const double before = cost_of(model_, noise_, base_.rig) - rows;
        const bool is_far = !input_.has_events && above > (bursts_exceed - 1.0) * rows;
        return exceeds_measured_floor() || (is_far && above > share_of_replay * before);
    }

    /* Where thresholds upstream switch at another moment than ours now and then, a stiff contact shows it: no cause
     * of its own, as long as it is little beside what the fault did. */
    bool is_rest_of_switching()
    {
        if (input_.without_switching_fault == nullptr) {
            return false;
        }
        const double rows = static_cast<double>(incumbent_.rows);
        return cost_of(model_, noise_, incumbent_.rig) - rows <
               left_full * (cost_of(model_, noise_, *input_.without_switching_fault) - rows);
    }

    double share_left()
    {
        const double total =
            std::max(cost_of(model_, noise_, base_.rig) - static_cast<double>(rows_under(noise_)), 1e-9);
        return std::min(1.0, std::max(0.0, leftover_.explained) / std::max(total, leftover_.explained));
    }

    /* Rows that say something of their own. */
    std::size_t rows_under(const noise_model &noise) const
    {
        const auto in_use = std::count(model_.uses().begin(), model_.uses().end(), row_use::fit);
        return static_cast<std::size_t>(static_cast<double>(in_use) / noise.rows_per_fact);
    }

    /* Far from the floor an error is no noise: colouring it would hide slow errors from the comparison. Near it, the
     * noise's own colour counts. */
    noise_model metric_for(const rig &rig)
    {
        constexpr double far = 2.5; /* times the floor */
        std::vector<double> error;
        model_.error(rig, error);
        if (rms_of(error, model_.uses(), row_use::fit) < far * noise_.rms) {
            return noise_;
        }
        noise_model white{{}, noise_.rms, noise_.rms, noise_.rows_per_fact};
        white.sigma *= std::sqrt(white.rows_per_fact);
        return white;
    }

    /* Candidates are compared under the noise that the best of them leaves. */
    void compare_anew(std::vector<candidate> &candidates)
    {
        if (!has_floor_) {
            const noise_model smaller = floor_under(model_, candidates.front().fitted.rig);
            if (smaller.rms < noise_.rms) {
                noise_ = smaller;
            }
        }
        metric_ = metric_for(candidates.front().fitted.rig);
        for (std::size_t i = 0; i < candidates.size(); i++) {
            candidate &one = candidates[i];
            if (i < 3 && !one.effect->is_rough) {
                one.fitted = fit(model_, metric_, one.fitted.rig, one.fitted.parameters, input_.options.replays_max);
            } else {
                one.fitted.cost = cost_of(model_, metric_, one.fitted.rig);
            }
            one.fitted.rows = rows_under(metric_);
            one.bic = bic_of(one.fitted.cost, one.fitted.rows, one.fitted.parameters.size());
        }
        std::sort(candidates.begin(), candidates.end(),
                  [](const candidate &a, const candidate &b) { return a.bic < b.bic; });
    }

    /* On the validation record or the parts held out. Where these show it hardly, or in a moment only, they prove
     * nothing: then the record's odd parts are predicted from its even ones and the other way round. */
    gain gain_of(const candidate &best)
    {
        constexpr double hardly = 0.05;
        paired_sums sums;
        add_sums(sums, unseen_ ? *unseen_ : model_, metric_, incumbent_.rig, best.fitted.rig,
                 unseen_ ? row_use::fit : row_use::held_out);
        const gain first = gain_from(sums);
        if (first.low > 0.0 || first.value < -hardly || best.effect->is_rough) {
            return first;
        }
        paired_sums crossed;
        for (const held_out_parts half : {held_out_parts::odd, held_out_parts::even}) {
            block_model model(model_.which(), *input_.fit, given_, events_, half);
            const fit_result with =
                fit(model, metric_, best.fitted.rig, best.fitted.parameters, input_.options.replays_max / 2);
            const fit_result without =
                fit(model, metric_, incumbent_.rig, incumbent_.parameters, input_.options.replays_max / 2);
            add_sums(crossed, model, metric_, without.rig, with.rig, row_use::held_out);
        }
        return gain_from(crossed);
    }

    /* Not in a few moments only, which our own precision may make up. */
    bool is_better_throughout(const candidate &one)
    {
        paired_sums sums;
        add_sums(sums, model_, metric_, incumbent_.rig, one.fitted.rig, row_use::fit);
        return blocks_that_differ(sums) > few_blocks;
    }

    bool find_next(block_diagnosis &result)
    {
        metric_ = metric_for(incumbent_.rig);
        std::vector<candidate> candidates =
            search_effects(model_, metric_, incumbent_, given_, found_, input_.options);
        if (candidates.empty()) {
            return false;
        }
        compare_anew(candidates);
        std::vector<double> error;
        model_.error(incumbent_.rig, error);
        const record_scales scales = scales_of(model_, incumbent_.rig, error);
        const auto is_none = [&](const candidate &one) {
            const bool is_seen = one.effect->is_seen == nullptr || one.effect->is_seen(one.fitted.rig, scales);
            return size_may_be_zero(one) || !is_seen;
        };
        candidates.erase(std::remove_if(candidates.begin(), candidates.end(), is_none), candidates.end());
        if (candidates.empty()) {
            return false;
        }
        incumbent_.cost = cost_of(model_, metric_, incumbent_.rig);
        incumbent_.rows = rows_under(metric_);
        const double bic_before = bic_of(incumbent_.cost, incumbent_.rows, incumbent_.parameters.size());
        const double explainable = excess(incumbent_.cost, incumbent_.rows);
        for (const candidate &one : candidates) {
            result.ranking.push_back({static_cast<int>(found_.size()) + 1, one.effect, bic_before - one.bic,
                                      (incumbent_.cost - one.fitted.cost) / explainable, one.fitted});
        }
        /* What refines an effect found before has to wait until nothing else is to be found. */
        std::stable_partition(candidates.begin(), candidates.end(),
                              [](const candidate &one) { return one.effect->refines.empty(); });
        const auto refining = std::find_if(candidates.begin(), candidates.end(),
                                           [](const candidate &one) { return !one.effect->refines.empty(); });
        for (auto first : {candidates.begin(), refining}) {
            if (first != candidates.end() && accept(result, candidates, *first, bic_before, explainable)) {
                return true;
            }
        }
        return false;
    }

    bool accept(block_diagnosis &result, const std::vector<candidate> &candidates, const candidate &best,
                double bic_before, double explainable)
    {
        const gain gained = gain_of(best);
        const double share = (incumbent_.cost - best.fitted.cost) / explainable;
        const double of_all =
            (incumbent_.cost - best.fitted.cost) /
            std::max(1e-9, cost_of(model_, metric_, base_.rig) - static_cast<double>(rows_under(metric_)));
        if (bic_before - best.bic < bic_clear || share < share_worthwhile || gained.low <= 0.0 ||
            gained.of_explainable < held_out_least ||
            of_all < (best.effect->refines.empty() ? share_of_all : share_of_all_refining)) {
            is_suspect_ = is_suspect_ || (bic_before - best.bic > bic_suspect && of_all > share_of_precision &&
                                          is_better_throughout(best));
            if (is_suspect_ && share > share_worthwhile) {
                result.alternatives.push_back({best.effect, best.bic - bic_before});
            }
            return false;
        }
        is_suspect_ = false;
        if (!best.effect->refines.empty()) {
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
            const double undecided = is_look_alike ? bic_look_alike : bic_undecided;
            if (&other != &best && distance < undecided && other.effect->refines == best.effect->refines &&
                other.effect->generalises != best.effect->name) {
                result.alternatives.push_back({other.effect, distance});
            }
        }
        incumbent_ = best.fitted;
        if (!best.effect->is_rough) {
            fit_without_colour();
            incumbent_ =
                fit(model_, noise_, incumbent_.rig, incumbent_.parameters, input_.options.replays_max);
        }
        incumbent_.cost = cost_of(model_, noise_, incumbent_.rig);
        incumbent_.rows = rows_under(noise_);
        start_over_from_given();
        if (best.effect->refines.empty()) {
            drop_stand_ins(result);
        }
        std::vector<double> error;
        model_.error(incumbent_.rig, error);
        leftover_ = find_leftover(model_, noise_, incumbent_.rig, error);
        return true;
    }

    /* A line that a fit has left was taken for the noise's own colour, which then hides it from the next fit: once
     * the noise counts as white, and its colour is measured anew. */
    void fit_without_colour()
    {
        if (has_floor_ || noise_.ar.empty()) {
            return;
        }
        const noise_model white{{}, noise_.rms, noise_.rms, noise_.rows_per_fact};
        const fit_result plain =
            fit(model_, white, incumbent_.rig, incumbent_.parameters, input_.options.replays_max);
        const noise_model under = floor_under(model_, plain.rig);
        if (under.rms < noise_.rms) {
            incumbent_ = plain;
            noise_ = under;
        }
    }

    /* The base was fitted to an error that has a cause now: where that led astray, the given values are the better
     * start. */
    void start_over_from_given()
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

    /* An effect found first may have stood in for one found later. */
    void drop_stand_ins(block_diagnosis &result)
    {
        for (std::size_t i = 0; i + 1 < found_.size();) {
            rig without = incumbent_.rig;
            std::vector<free_parameter> parameters;
            const effect &dropped = *found_[i];
            if (std::any_of(found_.begin(), found_.end(),
                            [&](const effect *other) { return other->refines == dropped.name; })) {
                i++;
                continue;
            }
            for (const effect_parameter &parameter : dropped.parameters) {
                set_number(without, parameter.key, value_of(given_, parameter.key));
            }
            if (dropped.switch_on != nullptr) {
                without.robot.clock = given_.robot.clock;
            }
            for (const free_parameter &parameter : incumbent_.parameters) {
                const bool is_its =
                    std::any_of(dropped.parameters.begin(), dropped.parameters.end(),
                                [&](const effect_parameter &own) { return own.key == parameter.key->path; });
                if (!is_its) {
                    parameters.push_back(parameter);
                }
            }
            parameters = joined(own_parameters(), parameters);
            fit_result tried = fit(model_, noise_, without, parameters, input_.options.replays_max);
            if (bic_of(tried.cost, tried.rows, parameters.size()) <
                bic_of(incumbent_.cost, incumbent_.rows, incumbent_.parameters.size()) + bic_clear) {
                incumbent_ = std::move(tried);
                found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(i));
                result.causes.erase(result.causes.begin() + static_cast<std::ptrdiff_t>(i));
            } else {
                i++;
            }
        }
    }

    /* Of the incumbent, over all rows. */
    std::vector<double> white_error_left()
    {
        std::vector<double> error;
        std::vector<double> white;
        std::vector<row_use> all = model_.uses();
        std::replace(all.begin(), all.end(), row_use::held_out, row_use::fit);
        model_.error(incumbent_.rig, error);
        whiten(noise_, error, all, row_use::fit, white);
        return white;
    }

    void conclude(block_diagnosis &result)
    {
        const std::vector<double> white = white_error_left();
        result.bad_moments = share_of_bad_moments(white, model_.data().period_s);
        /* What hangs on a threshold goes another way now and then: a few moments prove nothing else. */
        const bool only_moments =
            (!result.causes.empty() || input_.has_cause_upstream) && result.bad_moments < moments_bearable;
        result.left = share_left();
        result.left_class = leftover_.strongest;
        const bool has_thresholds =
            input_.without_switching_fault != nullptr ||
            std::any_of(found_.begin(), found_.end(), [](const effect *one) { return one->switches; });
        const bool bursts = noise_.rows_per_fact == 1.0 && !input_.has_events &&
                            !(only_moments && input_.has_cause_upstream) &&
                            has_bursts(white, model_.data().period_s);
        const bool exceeds_features =
            leftover_.explained > leftover_significant && (result.causes.empty() || result.left > left_full);
        const bool something_is_left = !is_rest_ && ((!only_moments && (exceeds_floor() || exceeds_features)) ||
                                                     (!(only_moments && has_thresholds) && (is_suspect_ || bursts)));
        if (result.causes.empty()) {
            result.verdict = something_is_left ? verdict::unknown : verdict::nothing_detectable;
        } else if (something_is_left) {
            result.verdict = verdict::partly_explained;
        } else {
            result.verdict = result.alternatives.empty() ? verdict::named : verdict::one_of;
        }
        fix_estimates(result);
        for (std::size_t i = 0; i < incumbent_.parameters.size(); i++) {
            const std::string key(incumbent_.parameters[i].key->path);
            result.base.push_back(
                {key, value_of(incumbent_.rig, key), incumbent_.ci95.empty() ? 0.0 : incumbent_.ci95[i]});
        }
        result.extended = incumbent_.rig;
        result.fitted = incumbent_;
        for (std::size_t i = 0; i < incumbent_.ci95.size(); i++) {
            const free_parameter &known = incumbent_.parameters[i];
            const double value = value_of(incumbent_.rig, known.key->path);
            const double sd = incumbent_.ci95[i] / 1.96;
            const bool is_rough = std::any_of(found_.begin(), found_.end(), [&](const effect *found) {
                return found->is_rough && found->parameters[0].key == known.key->path;
            });
            if (!is_rough && sd > 0.0 && sd < 0.1 * std::max(std::abs(value), is_angle(known) ? 1.0 : 0.0)) {
                result.refinable.push_back({known.key, value - 4.0 * sd, value + 4.0 * sd, value, sd});
            }
        }
        model_.error(incumbent_.rig, result.error_after);
        result.uses = model_.uses();
        result.floor = noise_;
        result.floor_is_measured = has_floor_;
        result.fit_rms = rms(model_, row_use::fit);
        result.held_out_rms = unseen_ ? rms(*unseen_, row_use::fit) : rms(model_, row_use::held_out);
    }

    void fix_estimates(block_diagnosis &result) const
    {
        for (cause &known : result.causes) {
            if (known.parameters.empty()) {
                known.parameters = estimates(incumbent_, *known.effect);
            }
        }
    }

    part_rms rms(block_model &model, row_use use) const
    {
        std::vector<double> error;
        part_rms made;
        model.error(given_, error);
        made.before = rms_of(error, model.uses(), use);
        model.error(base_.rig, error);
        made.retuned = rms_of(error, model.uses(), use);
        model.error(incumbent_.rig, error);
        made.after = rms_of(error, model.uses(), use);
        made.floor = noise_.rms;
        return made;
    }

    const diagnosis_input &input_;
    const rig &given_;
    const sample_events &events_;
    sample_events no_events_;
    block_model model_;
    std::unique_ptr<block_model> unseen_;
    noise_model noise_;
    noise_model metric_; /* what candidates are compared under */
    fit_result base_;
    fit_result incumbent_;
    leftover leftover_;
    bool has_floor_ = false; /* measured, and to be believed */
    bool is_suspect_ = false;
    bool is_rest_ = false;
    std::vector<const effect *> found_;
};

} // namespace

block_diagnosis diagnose_block(block block, const diagnosis_input &input, const rig &given, sample_events &events,
                               std::vector<event_finding> found_events)
{
    block_diagnosis result;
    result.block = block;
    find_single_samples(block, input, given, events, found_events);
    diagnosis_input known = input;
    known.has_events = !found_events.empty();
    block_search search(block, known, given, events);
    search.run(result);
    verify_spikes(block, input, result, events, found_events);
    if (block == block::force) {
        const auto steps = find_quantisation(*input.fit, given, result.fit_rms.after);
        found_events.insert(found_events.end(), steps.begin(), steps.end());
    }
    const auto &without = input.options.without;
    for (const event_finding &found : found_events) {
        const bool is_removed = std::find(without.begin(), without.end(), found.effect->name) != without.end();
        if (is_removed) {
            result.verdict = result.causes.empty() ? verdict::unknown : verdict::partly_explained;
            continue;
        }
        cause made;
        made.effect = found.effect;
        made.share_explained = 1.0;
        for (std::size_t i = 0; i < found.values.size(); i++) {
            made.parameters.push_back(
                {std::string(found.effect->parameters[i].key), found.values[i], found.ci95[i]});
            set_number(result.extended, found.effect->parameters[i].key, found.values[i]);
        }
        result.causes.push_back(made);
        if (result.verdict == verdict::nothing_detectable) {
            result.verdict = verdict::named;
        }
    }
    return result;
}

} // namespace berth
