#include <algorithm>
#include <cmath>
#include <string>

#include "../../../hal/rig/given.h"
#include "../noise/floor.h"
#include "../record/about_mean.h"
#include "acceptance.h"
#include "block_search.h"

namespace berth
{

namespace
{

/* In proportion to what a sensor in front of the object shows. */
bool is_force_of_object(std::string_view key)
{
    const std::string_view of_object = "object.";
    const std::string unit = std::string(key) + "_"; /* as if another one followed */
    const auto has = [&](std::string_view part) { return unit.find(part) != std::string::npos; };
    return key == "sensor.stiffness_N_per_m" ||
           (key.substr(0, of_object.size()) == of_object && (has("_kg_") || has("_N_")));
}

} // namespace

void block_search::withdraw_what_follows_nothing(block_diagnosis &result)
{
    constexpr double as_well = 1.1; /* times the error */
    if (found_.empty() || model_.which() == block::manipulator) {
        return; /* a manipulator that sticks has a cause that holds it */
    }
    if (rms_about_mean(model_) < as_well * rms_of(error_left(), model_.uses(), row_use::fit)) {
        follows_nothing_ = true;
        withdraw(result);
    }
}

bool block_search::may_be_none(const effect &known)
{
    const std::string_view size = known.parameters[0].key;
    for (std::size_t i = 0; i < incumbent_.ci95.size(); i++) {
        if (incumbent_.parameters[i].key->path == size) {
            const double given = value_of(given_, size);
            const double value = value_of(incumbent_.rig, size);
            /* Of what is given as unlimited its own size counts. */
            return std::abs(given < unlimited ? value - given : value) < incumbent_.ci95[i];
        }
    }
    return false;
}

void block_search::withdraw_what_may_be_none(block_diagnosis &result)
{
    const bool is_behind_switch = input_.without_switching_fault != nullptr && model_.which() == block::force;
    if (result.verdict != verdict::partly_explained || !(is_behind_switch || model_.which() == block::manipulator) ||
        !std::all_of(found_.begin(), found_.end(), [&](const effect *one) { return may_be_none(*one); })) {
        return;
    }
    const auto is_gone = [&](const ranked &one) {
        return one.round > 1 || std::find(found_.begin(), found_.end(), one.effect) != found_.end();
    };
    result.ranking.erase(std::remove_if(result.ranking.begin(), result.ranking.end(), is_gone),
                         result.ranking.end());
    withdraw(result);
    result.doubts.clear();
    verdict_of(result);
    result.verdict = verdict::unknown; /* however little is left: something was found in it */
    result.refinable = refinable();
    result.doubts.emplace_back(
        is_behind_switch ? "it lies behind a robot that switches, and beside it the size of a cause may be none"
                         : "beside what is left, the size of a cause may be none");
}

void block_search::keep_dead_time_possible()
{
    constexpr double ms_per_ns = 1e-6;
    const std::string_view key = "robot.dead_time_ms";
    const double least_ms = ms_per_ns * static_cast<double>(least_dead_time_ns(given_));
    if (value_of(incumbent_.rig, key) >= least_ms || is_robot_alone(given_)) {
        return;
    }
    rig possible = incumbent_.rig;
    set_number(possible, key, least_ms);
    std::vector<free_parameter> parameters = incumbent_.parameters;
    for (free_parameter &known : parameters) {
        if (known.key->path == key) {
            known.low = least_ms;
            known.high = std::max(known.high, 2.0 * least_ms);
        }
    }
    incumbent_ = fit(model_, noise_, possible, parameters, input_.options.replays_max);
    find_what_is_left();
}

void block_search::withdraw(block_diagnosis &result)
{
    found_.clear();
    result.causes.clear();
    result.alternatives.clear();
    incumbent_ = fit(model_, noise_, retuned_, base_.parameters, input_.options.replays_max);
    find_what_is_left();
}

bool block_search::holds_zero(const remains &)
{
    return std::any_of(found_.begin(), found_.end(), [&](const effect *known) {
        /* Of several parameters that the rig file has, another one than the first may be what is off. */
        const bool is_size = known->parameters.size() == 1 || value_of(given_, known->parameters[0].key) == 0.0;
        return is_size && may_be_none(*known);
    });
}

bool block_search::is_mode_of_robot(const remains &)
{
    constexpr double near = 0.1;
    const bool has_mode = std::any_of(found_.begin(), found_.end(),
                                      [](const effect *known) { return known->name == "object.second_mode"; });
    if (model_.which() != block::force || !has_mode || !input_.has_cause_upstream ||
        !incumbent_.rig.has_transfer_behaviour()) {
        return false;
    }
    const double robot_Hz = value_of(incumbent_.rig, "robot.transfer_frequency_Hz");
    return std::abs(value_of(incumbent_.rig, "object.second_frequency_Hz") - robot_Hz) < near * robot_Hz;
}

bool block_search::is_late_and_damped(const remains &)
{
    constexpr double as_much = 0.25;
    const auto is_found = [&](std::string_view name) {
        return std::any_of(found_.begin(), found_.end(), [&](const effect *known) { return known->name == name; });
    };
    if (!is_found("object.parameters") || !(is_found("sensor.lag") || is_found("sensor.delay"))) {
        return false;
    }
    const auto change = [&](std::string_view key) { return value_of(incumbent_.rig, key) - value_of(given_, key); };
    const double late_s = 1e-3 * (change("sensor.lag_ms") + change("sensor.delay_ms"));
    const double late_N_s_per_m = value_of(incumbent_.rig, "object.stiffness_N_per_m") * late_s;
    return std::abs(change("object.damping_N_s_per_m") - late_N_s_per_m) < as_much * std::abs(late_N_s_per_m);
}

bool block_search::is_another_body(const remains &)
{
    constexpr double times = 100.0;
    const auto is_far_off = [&](const effect_parameter &own) {
        const double given = value_of(given_, own.key);
        const double ratio = value_of(incumbent_.rig, own.key) / given;
        /* Not those of what hangs on it: an effect that the rig file has may be gone. */
        const std::string_view name = own.key.substr(own.key.find('.') + 1);
        const bool is_of_body = name == "mass_kg" || name == "stiffness_N_per_m";
        return is_of_body && given > 0.0 && given < unlimited && (ratio < 1.0 / times || ratio > times);
    };
    return std::any_of(found_.begin(), found_.end(), [&](const effect *known) {
        return std::any_of(known->parameters.begin(), known->parameters.end(), is_far_off);
    });
}

void block_search::withdraw_gain_of_scaled_object(block_diagnosis &result)
{
    const auto gain =
        std::find_if(found_.begin(), found_.end(), [](const effect *known) { return known->name == "sensor.gain"; });
    if (gain == found_.end() || found_.size() < 2) {
        return;
    }
    const std::string_view key = (*gain)->parameters[0].key;
    const double scale = (1.0 + value_of(incumbent_.rig, key)) / (1.0 + value_of(given_, key));
    rig scaled = rig_without(**gain);
    std::vector<free_parameter> parameters;
    for (const free_parameter &known : incumbent_.parameters) {
        const std::string_view path = known.key->path;
        if (path == key) {
            continue;
        }
        parameters.push_back(known);
        if (is_force_of_object(path)) {
            set_number(scaled, path, scale * value_of(incumbent_.rig, path));
        }
    }
    fit_result without = fit(model_, noise_, scaled, parameters, input_.options.replays_max);
    const double worse = bic_of(without.cost, without.rows, without.parameters.size()) - bic_better_by(0.0);
    may_be_scaled_object_ = worse < bic_undecided;
    if (worse < 0.0) {
        may_be_scaled_object_ = false;
        incumbent_ = std::move(without);
        result.causes.erase(result.causes.begin() + (gain - found_.begin()));
        found_.erase(gain);
        find_what_is_left();
    }
}

} // namespace berth
