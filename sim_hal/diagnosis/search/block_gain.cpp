#include <algorithm>
#include <cmath>

#include "../samples/clock_slips.h"
#include "acceptance.h"
#include "block_search.h"

namespace berth
{

gain block_search::gain_on_unseen(const candidate &best)
{
    block_model &model = unseen_ ? *unseen_ : model_;
    const std::vector<row_use> uses = model.uses();
    const bool may_slip = unseen_ != nullptr && input_.without_switching_fault != nullptr &&
                          incumbent_.rig.robot.clock == robot_clock::free;
    if (may_slip) {
        model.use(uses_beside_slips(model, incumbent_.rig));
    }
    paired_sums sums;
    add_sums(sums, model, metric_, incumbent_.rig, best.fitted.rig, unseen_ ? row_use::fit : row_use::held_out);
    gain made = gain_from(sums);
    if (predicts_worse(best)) {
        made.low = std::min(made.low, 0.0);
    }
    model.use(uses);
    return made;
}

gain block_search::gain_of(const candidate &best, bool may_act_in_one_stretch)
{
    constexpr double hardly = 0.05;
    const gain first = gain_on_unseen(best);
    if (first.low > 0.0 || first.value < -hardly || predicts_worse(best)) {
        return first;
    }
    if (unseen_ != nullptr && input_.without_switching_fault != nullptr && is_far_on_unseen(best.fitted.rig)) {
        return first; /* it shows much, and the candidate hardly any of that */
    }
    const gain crossed = crossed_gain(best, halves_by_tenths());
    const bool shows_it = crossed.low > 0.0 && crossed.of_explainable >= held_out_least;
    return shows_it || !may_act_in_one_stretch ? crossed : crossed_gain(best, halves_where_it_acts(best));
}

gain block_search::crossed_gain(const candidate &best, const halves &held_out)
{
    paired_sums crossed;
    for (const std::vector<row_use> &half : held_out) {
        block_model model(model_.which(), *input_.fit, given_, events_.fit, held_out_parts::none);
        model.use(half);
        search_options half_as_long = input_.options;
        half_as_long.replays_max /= 2;
        const fit_result without =
            fit(model, metric_, incumbent_.rig, incumbent_.parameters, half_as_long.replays_max);
        fit_result with = fit_effect(model, metric_, *best.effect, best.fitted, without, half_as_long);
        if (with.cost > without.cost - bic_clear) {
            with = without; /* this half knows nothing of it */
        }
        add_sums(crossed, model, metric_, without.rig, with.rig, row_use::held_out);
    }
    return gain_from(crossed);
}

bool block_search::is_far_on_unseen(const rig &rig)
{
    constexpr double far = 4.0; /* of the white sum of squares */
    const auto rows = std::count(unseen_->uses().begin(), unseen_->uses().end(), row_use::fit);
    return cost_of(*unseen_, metric_, rig) > far * static_cast<double>(rows) / metric_.rows_per_fact;
}

bool block_search::predicts_worse(const candidate &best)
{
    constexpr double worse =
        1.005; /* of the plain error: weighted by the noise's colour, a slow one hardly counts */
    if (unseen_ == nullptr) {
        return false;
    }
    const auto plain_rms = [&](const rig &rig) {
        std::vector<double> error;
        unseen_->error(rig, error);
        return rms_of(error, unseen_->uses(), row_use::fit);
    };
    return plain_rms(best.fitted.rig) > worse * plain_rms(incumbent_.rig);
}

block_search::halves block_search::halves_by_tenths() const
{
    const auto uses = [&](held_out_parts parts) {
        return block_model(model_.which(), *input_.fit, given_, events_.fit, parts).uses();
    };
    return {uses(held_out_parts::odd), uses(held_out_parts::even)};
}

block_search::halves block_search::halves_where_it_acts(const candidate &best)
{
    constexpr double parts = 8.0;
    block_model model(model_.which(), *input_.fit, given_, events_.fit, held_out_parts::none);
    std::vector<double> before;
    std::vector<double> after;
    model.error(incumbent_.rig, before);
    model.error(best.fitted.rig, after);
    double all = 0.0;
    for (std::size_t n = 0; n < before.size(); n++) {
        all += std::pow(before[n] - after[n], 2);
    }
    halves made{model.uses(), model.uses()};
    double sum = 0.0;
    for (std::size_t n = 0; n < before.size(); n++) {
        sum += std::pow(before[n] - after[n], 2);
        std::vector<row_use> &seen_by_other = made[static_cast<int>(parts * sum / std::max(all, 1e-300)) % 2];
        if (seen_by_other[n] == row_use::fit) {
            seen_by_other[n] = row_use::held_out;
        }
    }
    return made;
}

bool block_search::is_better_throughout(const candidate &one)
{
    paired_sums sums;
    add_sums(sums, model_, metric_, incumbent_.rig, one.fitted.rig, row_use::fit);
    return blocks_that_differ(sums) > few_blocks;
}

} // namespace berth
