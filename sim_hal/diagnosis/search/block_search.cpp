#include "block_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "../fit/base.h"
#include "../noise/floor.h"
#include "../record/command_steps.h"
#include "../record/motion_noise.h"
#include "../record/written_digits.h"
#include "../samples/clock_slips.h"

namespace berth
{

block_search::block_search(block block, const diagnosis_input &input, const rig &given,
                           const events_of_records &events)
    : input_(input), given_(given), events_(events),
      model_(block, *input.fit, given, events.fit,
             input.validation == nullptr ? held_out_parts::two_tenths : held_out_parts::none)
{
    if (input.validation != nullptr) {
        unseen_ =
            std::make_unique<block_model>(block, *input.validation, given, events.unseen, held_out_parts::none);
    }
}

void block_search::run(block_diagnosis &result)
{
    result.as_given = given_;
    model_.error(given_, result.error_before);
    look_at_command_steps();
    fit_base();
    if (balance_parts()) {
        fit_base();
    }
    if (take_steps_as_sent()) {
        fit_base();
    }
    base_ = incumbent_;
    retuned_ = base_.rig;
    rate_base(result);
    if (model_.which() == block::manipulator) {
        input_steps_rms_ = rms_of_written_digits(model_, retuned_);
    }
    const bool is_rounding = is_within_rounding();
    is_rest_ = is_rest_of_switching() || is_rounding || is_of_our_steps(model_);
    const int rounds_max = 2 * input_.effects_max; /* what stood in for another one makes room for a further one */
    for (int round = 0; round < rounds_max && static_cast<int>(found_.size()) < input_.effects_max && !is_rounding &&
                        !is_within_input_steps() && !stands_within_its_step() && !is_of_our_steps(model_);
         round++) {
        if (!find_next(result) && !add_pair(result) && !bring_in_two(result) && !find_while_held(result)) {
            break;
        }
    }
    divide_stand_in(result);
    look_at_slips();
    is_rest_ =
        is_rest_ || stands_within_its_step() || (model_.which() == block::manipulator && is_within_input_steps());
    conclude(result);
}

std::vector<free_parameter> block_search::own_parameters() const
{
    return joined(input_.upstream, base_parameters(model_.which(), given_));
}

void block_search::look_at_command_steps()
{
    if (model_.which() == block::manipulator) {
        return;
    }
    constexpr double hardly_more = 1.1; /* another rounding of them may leave as much */
    input_steps_rms_ = rms_of_command_steps(model_.which(), model_.data(), given_, events_.fit);
    const double noise_rms = input_steps_rms_ > 0.0 ? noise_from_row_to_row(model_.data(), model_.measured()) : 0.0;
    if (is_of_input_steps(0.0, input_steps_rms_, noise_rms)) {
        model_.leave_open(hardly_more * std::hypot(input_steps_rms_, noise_rms));
    }
}

bool block_search::take_steps_as_sent()
{
    if (model_.open_by_input_rms() == 0.0 ||
        !were_steps_sent(model_.which(), model_.data(), incumbent_.rig, events_.fit)) {
        return false;
    }
    input_steps_rms_ = 0.0;
    model_.leave_open(0.0);
    return true;
}

void block_search::fit_base()
{
    const auto parameters = own_parameters();
    std::vector<double> error;
    model_.error(given_, error);
    const bool has_measured = input_.floor && model_.rows_per_fact() == 1.0;
    noise_ = has_measured ? at_least(*input_.floor, std::max(model_.rounding_rms(), model_.open_by_input_rms()))
                          : noise_of(model_, error, true);
    incumbent_.rig = given_;
    if (is_behind_slips()) {
        uses_with_slips_ = model_.uses();
        model_.use(uses_beside_slips(model_, given_));
        const auto base = base_parameters(model_.which(), given_);
        incumbent_ = fit(model_, noise_, given_, base, input_.options.base_replays_max);
    }
    incumbent_ = fit(model_, noise_, incumbent_.rig, parameters, input_.options.base_replays_max);
    const noise_model under = floor_under(model_, incumbent_.rig);
    /* Runs that repeat a command need not repeat what came of it: a floor above the error itself is none. */
    has_floor_ = has_measured && input_.floor->rms < 1.25 * under.rms;
    if (!has_floor_) {
        noise_ = under;
        incumbent_ = fit(model_, noise_, incumbent_.rig, parameters, input_.options.base_replays_max);
        renew_floor();
    }
}

bool block_search::is_behind_slips() const
{
    return input_.without_switching_fault != nullptr && given_.robot.clock == robot_clock::free;
}

void block_search::look_at_slips()
{
    constexpr int rounds_max = 4;
    if (!is_behind_slips()) {
        return;
    }
    model_.use(uses_with_slips_);
    double before = unlimited;
    incumbent_.cost = cost_of(model_, noise_, incumbent_.rig);
    for (int round = 0; round < rounds_max && incumbent_.cost < before; round++) {
        before = incumbent_.cost;
        match_slips(model_, incumbent_);
        incumbent_ = fit(model_, noise_, incumbent_.rig, incumbent_.parameters, input_.options.replays_max);
    }
    fit_result retuned = incumbent_;
    retuned.rig = retuned_;
    match_slips(model_, retuned);
    retuned_ = found_.empty() ? incumbent_.rig : retuned.rig;
}

bool block_search::balance_parts()
{
    if (unseen_ != nullptr) {
        return false;
    }
    std::vector<double> error;
    model_.error(incumbent_.rig, error);
    const auto squares = model_.mean_squares_of_tenths(error);
    const double all = std::accumulate(squares.begin(), squares.end(), 0.0);
    /* Mean square where it is held out by that where it is fitted, of as many times as many tenths. */
    const auto ratio = [&](std::size_t a, std::size_t b) {
        const double held = squares[a] + squares[b];
        return (held / 2.0) / std::max((all - held) / 8.0, 1e-300);
    };
    constexpr double unlike = 3.0;
    std::array<std::size_t, 2> best{3, 7};
    const auto off = [&](std::size_t a, std::size_t b) { return std::abs(std::log(std::max(ratio(a, b), 1e-300))); };
    if (off(best[0], best[1]) < std::log(unlike)) {
        return false;
    }
    for (std::size_t a = 1; a < squares.size(); a++) {
        for (std::size_t b = a + 2; b < squares.size(); b++) {
            if (off(a, b) < off(best[0], best[1])) {
                best = {a, b};
            }
        }
    }
    model_.hold_out(best);
    return true;
}

void block_search::find_what_is_left()
{
    std::vector<double> error;
    model_.error(incumbent_.rig, error);
    leftover_ = find_leftover(model_, noise_, incumbent_.rig, error);
}

void block_search::rate_base(block_diagnosis &result)
{
    find_what_is_left();
    result.explainable = excess(incumbent_.cost, incumbent_.rows);
}

std::size_t block_search::rows_under(const noise_model &noise) const
{
    const auto in_use = std::count(model_.uses().begin(), model_.uses().end(), row_use::fit);
    return static_cast<std::size_t>(static_cast<double>(in_use) / noise.rows_per_fact);
}

double block_search::excess(double cost, std::size_t rows) const
{
    /* A floor that was found in the error itself, blind to what is unusual, is a little low. */
    const double blindness = has_floor_ ? 0.0 : 0.04;
    return std::max({cost - (1.0 + blindness) * static_cast<double>(rows), leftover_.share_of_rms * cost, 1e-9});
}

bool block_search::is_within_rounding()
{
    constexpr double dominates = 0.9;
    constexpr double hardly_more = 1.1; /* of the square: what was rounded on the way to the replay is rounded too */
    constexpr double far_below = 0.1;   /* of the noise: the replay's own digits */
    return is_within_input_steps() ||
           (model_.rounding_rms() > dominates * noise_.rms &&
            incumbent_.cost <= hardly_more * static_cast<double>(incumbent_.rows)) ||
           rms_of(error_left(), model_.uses(), row_use::fit) < far_below * noise_.rms;
}

bool block_search::stands_within_its_step()
{
    constexpr double long_rows = 4.0;
    constexpr double beyond = 0.7; /* of the step: half of it, and noise of less than a tenth */
    constexpr double few = 0.01;
    const double step = model_.rounding_rms() * std::sqrt(12.0);
    if (rows_of_a_reading(model_.measured(), model_.uses()) < long_rows) {
        return false;
    }
    const std::vector<double> error = error_left();
    std::size_t rows = 0;
    std::size_t rows_beyond = 0;
    for (std::size_t n = 0; n < error.size(); n++) {
        const bool is_in_use = model_.uses()[n] == row_use::fit;
        rows += is_in_use;
        rows_beyond += is_in_use && std::abs(error[n]) > beyond * step;
    }
    return static_cast<double>(rows_beyond) <= few * static_cast<double>(rows);
}

bool block_search::is_within_input_steps()
{
    if (input_steps_rms_ == 0.0) {
        return false;
    }
    const double noise_rms =
        model_.which() == block::manipulator ? noise_.rms : noise_from_row_to_row(model_.data(), model_.measured());
    return is_of_input_steps(rms_of(error_left(), model_.uses(), row_use::fit), input_steps_rms_, noise_rms);
}

noise_model block_search::metric_for(const rig &rig)
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

part_rms block_search::rms(block_model &model, row_use use) const
{
    std::vector<double> error;
    part_rms made;
    model.error(given_, error);
    made.before = rms_of(error, model.uses(), use);
    model.error(retuned_, error);
    made.retuned = rms_of(error, model.uses(), use);
    model.error(incumbent_.rig, error);
    made.after = rms_of(error, model.uses(), use);
    made.floor = noise_.rms;
    return made;
}

} // namespace berth
