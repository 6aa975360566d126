#include "block_diagnosis.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace berth
{

namespace
{

/* Improvements of the white sum of squares by features with no meaning stay far below this. */
constexpr double leftover_significant = 40.0;

constexpr double bic_clear = 20.0; /* an effect must improve BIC by this */
constexpr double moments_bearable = 0.04;
constexpr double bic_undecided = 30.0;   /* two causes nearer than this cannot be told apart */
constexpr double share_worthwhile = 0.3; /* of the explainable error */
constexpr double left_full = 0.08;       /* share of it that may be left of a full explanation */
constexpr double floor_exceeded = 1.21;  /* white sum of squares per row: 1.1 times the floor */

struct gain {
    double value;
    double low;
    double high;
};

/* How much the white sum of squares falls on rows that no fit has seen; interval by resampling blocks of half a
 * second, which keeps what hangs together together. */
gain held_out_gain(block_model &model, const noise_model &noise, const rig &before, const rig &after,
                   double period_s, row_use use)
{
    std::vector<double> error;
    std::vector<double> white_before;
    std::vector<double> white_after;
    model.error(before, error);
    whiten(noise, error, model.uses(), use, white_before);
    model.error(after, error);
    whiten(noise, error, model.uses(), use, white_after);
    const std::size_t rows = white_before.size();
    const auto length = std::max<std::size_t>(5, std::min(rows / 10, static_cast<std::size_t>(0.5 / period_s)));
    std::vector<double> sums_before;
    std::vector<double> sums_after;
    for (std::size_t begin = 0; begin + length <= rows; begin += length) {
        double before_sum = 0.0;
        double after_sum = 0.0;
        for (std::size_t n = begin; n < begin + length; n++) {
            before_sum += white_before[n] * white_before[n];
            after_sum += white_after[n] * white_after[n];
        }
        sums_before.push_back(before_sum);
        sums_after.push_back(after_sum);
    }
    if (sums_before.size() < 4) {
        return {0.0, -1.0, 1.0};
    }
    const auto gain_of = [&](const std::vector<std::size_t> &blocks) {
        double b = 0.0;
        double a = 0.0;
        for (const std::size_t i : blocks) {
            b += sums_before[i];
            a += sums_after[i];
        }
        return b > 0.0 ? 1.0 - a / b : 0.0;
    };
    std::vector<std::size_t> blocks(sums_before.size());
    for (std::size_t i = 0; i < blocks.size(); i++) {
        blocks[i] = i;
    }
    gain result{gain_of(blocks), 0.0, 0.0};
    std::mt19937 engine(1); /* the same record gives the same verdict */
    std::uniform_int_distribution<std::size_t> any(0, blocks.size() - 1);
    std::vector<double> gains;
    for (int trial = 0; trial < 400; trial++) {
        for (std::size_t &i : blocks) {
            i = any(engine);
        }
        gains.push_back(gain_of(blocks));
    }
    std::sort(gains.begin(), gains.end());
    result.low = gains[10];
    result.high = gains[389];
    return result;
}

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

/* Refits, first with all errors alike, then weighted by the noise that is left when what depends on the state is
 * taken out. */
noise_model floor_under(block_model &model, const rig &rig)
{
    std::vector<double> error;
    model.error(rig, error);
    noise_model noise = estimate_noise(error, model.uses(), 0);
    for (int pass = 0; pass < 2; pass++) {
        noise = estimate_noise(find_leftover(model, noise, rig, error).unexplained, model.uses());
    }
    return at_least(noise, resolution_rms(model.which()));
}

class block_search
{
  public:
    block_search(block block, const diagnosis_input &input, const rig &given, const sample_events &events)
        : input_(input), given_(given), model_(block, *input.fit, given, events, input.validation == nullptr)
    {
        if (input.validation != nullptr) {
            unseen_ = std::make_unique<block_model>(block, *input.validation, given, no_events_, false);
        }
    }

    block_model &model() { return model_; }

    void run(block_diagnosis &result)
    {
        model_.error(given_, result.error_before);
        fit_base();
        base_ = incumbent_;
        rate_base(result);
        for (int round = 0; round < input_.effects_max && is_worth_going_on(result); round++) {
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
        noise_ = input_.floor ? *input_.floor : estimate_noise(error, model_.uses(), 0);
        incumbent_ = fit(model_, noise_, given_, parameters, input_.options.replays_max);
        if (!input_.floor) {
            noise_ = floor_under(model_, incumbent_.rig);
            incumbent_ = fit(model_, noise_, incumbent_.rig, parameters, input_.options.replays_max);
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
        return std::max({cost - static_cast<double>(rows), leftover_.explained, 1e-9});
    }

    bool exceeds_measured_floor() const
    {
        return input_.floor && incumbent_.cost > floor_exceeded * static_cast<double>(incumbent_.rows);
    }

    bool is_worth_going_on(const block_diagnosis &result)
    {
        /* What plain features do not see, an effect of the library may. */
        return result.causes.empty() ||
               (share_left() > 0.02 && (leftover_.explained > leftover_significant || exceeds_measured_floor()));
    }

    double share_left()
    {
        const double total = std::max(cost_of(model_, noise_, base_.rig) - static_cast<double>(base_.rows), 1e-9);
        return std::min(1.0, std::max(0.0, leftover_.explained) / std::max(total, leftover_.explained));
    }

    /* Candidates are compared under the noise that the best of them leaves. */
    void compare_anew(std::vector<candidate> &candidates)
    {
        if (!input_.floor) {
            const noise_model smaller = floor_under(model_, candidates.front().fitted.rig);
            if (smaller.rms < noise_.rms) {
                noise_ = smaller;
            }
        }
        for (std::size_t i = 0; i < candidates.size(); i++) {
            candidate &one = candidates[i];
            if (i < 3 && !input_.floor && !one.effect->is_rough) {
                one.fitted = fit(model_, noise_, one.fitted.rig, one.fitted.parameters, input_.options.replays_max);
            } else {
                one.fitted.cost = cost_of(model_, noise_, one.fitted.rig);
            }
            one.bic = bic_of(one.fitted.cost, one.fitted.rows, one.fitted.parameters.size());
        }
        std::sort(candidates.begin(), candidates.end(),
                  [](const candidate &a, const candidate &b) { return a.bic < b.bic; });
    }

    bool find_next(block_diagnosis &result)
    {
        std::vector<candidate> candidates =
            search_effects(model_, noise_, incumbent_, given_, found_, input_.options);
        if (candidates.empty()) {
            return false;
        }
        compare_anew(candidates);
        incumbent_.cost = cost_of(model_, noise_, incumbent_.rig);
        const double bic_before = bic_of(incumbent_.cost, incumbent_.rows, incumbent_.parameters.size());
        const candidate &best = candidates.front();
        const double explainable = excess(incumbent_.cost, incumbent_.rows);
        for (const candidate &one : candidates) {
            result.ranking.push_back({static_cast<int>(found_.size()) + 1, one.effect, bic_before - one.bic,
                                      (incumbent_.cost - one.fitted.cost) / explainable});
        }

        block_model &unseen = unseen_ ? *unseen_ : model_;
        const row_use use = unseen_ ? row_use::fit : row_use::held_out;
        const gain gained =
            held_out_gain(unseen, noise_, incumbent_.rig, best.fitted.rig, model_.data().period_s, use);
        const double share = (incumbent_.cost - best.fitted.cost) / explainable;
        if (bic_before - best.bic < bic_clear || share < share_worthwhile || gained.low <= 0.0) {
            return false;
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
        for (std::size_t i = 1; i < candidates.size(); i++) {
            const double distance = candidates[i].bic - best.bic;
            if (distance < bic_undecided) {
                result.alternatives.push_back({candidates[i].effect, distance});
            }
        }
        incumbent_ = best.fitted;
        drop_stand_ins(result);
        std::vector<double> error;
        model_.error(incumbent_.rig, error);
        leftover_ = find_leftover(model_, noise_, incumbent_.rig, error);
        return true;
    }

    /* An effect found first may have stood in for one found later. */
    void drop_stand_ins(block_diagnosis &result)
    {
        for (std::size_t i = 0; i + 1 < found_.size();) {
            rig without = incumbent_.rig;
            std::vector<free_parameter> parameters;
            const effect &dropped = *found_[i];
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

    /* Share of half seconds in which the white error is well above the floor. */
    double bad_moments()
    {
        std::vector<double> error;
        std::vector<double> white;
        model_.error(incumbent_.rig, error);
        whiten(noise_, error, model_.uses(), row_use::fit, white);
        const auto length = std::max<std::size_t>(10, static_cast<std::size_t>(0.5 / model_.data().period_s));
        std::size_t bad = 0;
        std::size_t all = 0;
        for (std::size_t begin = 0; begin + length <= white.size(); begin += length, all++) {
            double sum = 0.0;
            for (std::size_t n = begin; n < begin + length; n++) {
                sum += white[n] * white[n];
            }
            bad += sum > 1.6 * static_cast<double>(length);
        }
        return all > 0 ? static_cast<double>(bad) / static_cast<double>(all) : 0.0;
    }

    void conclude(block_diagnosis &result)
    {
        result.bad_moments = bad_moments();
        /* What hangs on a threshold goes another way now and then: a few moments prove nothing else. */
        const bool only_moments =
            (!result.causes.empty() || input_.has_cause_upstream) && result.bad_moments < moments_bearable;
        result.left = share_left();
        result.left_class = leftover_.strongest;
        const bool something_is_left =
            !only_moments && (exceeds_measured_floor() || (leftover_.explained > leftover_significant &&
                                                           (result.causes.empty() || result.left > left_full)));
        if (result.causes.empty()) {
            result.verdict = something_is_left ? verdict::unknown : verdict::nothing_detectable;
        } else if (something_is_left) {
            result.verdict = verdict::partly_explained;
        } else {
            result.verdict = result.alternatives.empty() ? verdict::named : verdict::one_of;
        }
        for (cause &known : result.causes) {
            known.parameters = estimates(incumbent_, *known.effect);
        }
        for (std::size_t i = 0; i < incumbent_.parameters.size(); i++) {
            const std::string key(incumbent_.parameters[i].key->path);
            result.base.push_back(
                {key, value_of(incumbent_.rig, key), incumbent_.ci95.empty() ? 0.0 : incumbent_.ci95[i]});
        }
        result.extended = incumbent_.rig;
        for (std::size_t i = 0; i < incumbent_.ci95.size(); i++) {
            const free_parameter &known = incumbent_.parameters[i];
            const double value = value_of(incumbent_.rig, known.key->path);
            const double sd = incumbent_.ci95[i] / 1.96;
            const bool is_rough = std::any_of(found_.begin(), found_.end(), [&](const effect *found) {
                return found->is_rough && found->parameters[0].key == known.key->path;
            });
            if (!is_rough && sd > 0.0 && sd < 0.1 * std::abs(value)) {
                result.refinable.push_back({known.key, value - 4.0 * sd, value + 4.0 * sd, value, sd});
            }
        }
        model_.error(incumbent_.rig, result.error_after);
        result.uses = model_.uses();
        result.floor = noise_;
        result.floor_is_measured = input_.floor.has_value();
        result.fit_rms = rms(model_, row_use::fit);
        result.held_out_rms = unseen_ ? rms(*unseen_, row_use::fit) : rms(model_, row_use::held_out);
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
    sample_events no_events_;
    block_model model_;
    std::unique_ptr<block_model> unseen_;
    noise_model noise_;
    fit_result base_;
    fit_result incumbent_;
    leftover leftover_;
    std::vector<const effect *> found_;
};

} // namespace

block_diagnosis diagnose_block(block block, const diagnosis_input &input, const rig &given, sample_events &events,
                               std::vector<event_finding> found_events)
{
    block_diagnosis result;
    result.block = block;
    {
        /* Single samples first: they would spoil every fit. */
        block_model model(block, *input.fit, given, events, false);
        std::vector<double> error;
        const fit_result base = fit(model, estimate_noise((model.error(given, error), error), model.uses(), 0),
                                    given, base_parameters(block, given), input.options.replays_max);
        model.error(base.rig, error);
        std::vector<event_finding> more;
        if (block == block::force) {
            more = find_spikes(model, error, events);
        } else if (block == block::robot) {
            more = find_lost_commands(model, base.rig, error, events);
        }
        found_events.insert(found_events.end(), more.begin(), more.end());
    }
    block_search search(block, input, given, events);
    search.run(result);
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
