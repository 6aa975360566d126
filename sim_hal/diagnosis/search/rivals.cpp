#include "rivals.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "../fit/base.h"

namespace berth
{

namespace
{

/* Of the white sums of squares: one in 600 by chance, and as much the other way is more than three standard
 * deviations from where the truth would be. */
constexpr double clearly = 10.0;
/* More of it, for each parameter that the better one has more: by chance two of them earn 18 once in 8000 (chi2). */
constexpr double earned_by_chance = 4.0;

/* A rival by itself, with all that was fitted. */
struct contender {
    const berth::effect *effect = nullptr;
    block_diagnosis robot;
    block_diagnosis force;
    events_of_records events;
};

bool has_size(const block_diagnosis &block, std::string_view key)
{
    return std::any_of(block.causes.begin(), block.causes.end(), [&](const cause &found) {
        return std::any_of(found.parameters.begin(), found.parameters.end(),
                           [&](const auto &size) { return size.key == key; });
    });
}

/* How far the base model's parameters are from what the rig file says of them; those of a cause may be anywhere. */
double strain_on_base(const rig &given, const contender &one)
{
    double sum = 0.0;
    for (const block block : {block::robot, block::force}) {
        for (const free_parameter &known : base_parameters(block, given)) {
            const bool is_of_cause = has_size(one.robot, known.key->path) || has_size(one.force, known.key->path);
            if (!is_of_cause && known.expected_sd < unlimited) {
                sum += std::pow(strain_of(known, one.force.extended), 2);
            }
        }
    }
    return sum;
}

/* Weighs rigs by reports and force, under the noise that the named cause leaves. */
class balance
{
  public:
    balance(const contender &named, const diagnosis_input &input, const rig &as_given)
        : as_given_(as_given), robot_noise_(named.robot.floor), force_noise_(named.force.floor),
          reports_(block::robot, *input.fit, as_given, named.events.fit, held_out_parts::none),
          force_(block::force, *input.fit, as_given, named.events.fit, held_out_parts::none)
    {
    }

    double weight_of(const contender &one)
    {
        return cost_of(reports_, robot_noise_, one.force.extended) +
               cost_of(force_, force_noise_, one.force.extended) + strain_on_base(as_given_, one);
    }

  private:
    const rig &as_given_;
    noise_model robot_noise_;
    noise_model force_noise_;
    block_model reports_;
    block_model force_;
};

contender fitted_alone(std::string_view effect, const std::vector<std::string> &rivals,
                       const block_start &robot_start, const block_start &force_start, const rig &as_given)
{
    block_start alone = robot_start;
    std::copy_if(rivals.begin(), rivals.end(), std::back_inserter(alone.input.options.without),
                 [&](const std::string &other) { return other != effect; });
    contender made;
    made.effect = find_effect(effect);
    made.events = alone.events;
    made.robot = diagnose_block(block::robot, alone.input, alone.given, made.events, alone.found_events);
    diagnosis_input input = force_start.input;
    know_robot(input, made.robot, as_given);
    made.force = diagnose_block(block::force, input, made.robot.extended, made.events, force_start.found_events);
    return made;
}

bool is_clearly_worse(const contender &one, double weight, const contender &best, double least)
{
    const auto size = [](const contender &other) { return static_cast<double>(other.effect->parameters.size()); };
    return weight >= least + clearly + earned_by_chance * std::max(0.0, size(best) - size(one));
}

/* And leaves the force to the same causes of its own as before, if any. */
bool explains_all(const contender &one, std::string_view effect, const block_diagnosis &force)
{
    const auto is_same = [](const cause &a, const cause &b) { return a.effect == b.effect; };
    return one.robot.verdict == verdict::named && one.force.verdict == force.verdict &&
           std::equal(one.force.causes.begin(), one.force.causes.end(), force.causes.begin(), force.causes.end(),
                      is_same) &&
           std::any_of(one.robot.causes.begin(), one.robot.causes.end(),
                       [&](const cause &known) { return known.effect->name == effect; });
}

} // namespace

void weigh_rivals_together(block_diagnosis &robot, block_diagnosis &force, events_of_records &events,
                           const block_start &robot_start, const block_start &force_start, const rig &as_given)
{
    const effect *const of = robot.alternatives.front().rival_of;
    std::vector<std::string> names = {std::string((of == nullptr ? robot.causes.back().effect : of)->name)};
    for (const alternative &other : robot.alternatives) {
        if (other.rival_of == of) {
            names.emplace_back(other.effect->name);
        }
    }
    std::vector<contender> rivals;
    for (const std::string &name : names) {
        rivals.push_back(fitted_alone(name, names, robot_start, force_start, as_given));
        if (!explains_all(rivals.back(), name, force)) {
            rivals.pop_back();
        }
        if (rivals.empty()) {
            return; /* what was named by itself is not even sure alone */
        }
    }
    balance scales(rivals[0], force_start.input, as_given);
    std::vector<double> weights;
    weights.reserve(rivals.size());
    for (const contender &one : rivals) {
        weights.push_back(scales.weight_of(one));
    }
    const auto best = static_cast<std::size_t>(std::min_element(weights.begin(), weights.end()) - weights.begin());
    /* Within what tells them apart the one that was named stays so. */
    const std::size_t named = is_clearly_worse(rivals[0], weights[0], rivals[best], weights[best]) ? best : 0;
    for (std::size_t i = 0; i < rivals.size(); i++) {
        if (i != named && !is_clearly_worse(rivals[i], weights[i], rivals[best], weights[best])) {
            rivals[named].robot.alternatives.push_back({rivals[i].effect, weights[i] - weights[named],
                                                        of == nullptr ? nullptr : rivals[named].effect,
                                                        rivals[i].robot.fitted});
        }
    }
    robot = std::move(rivals[named].robot);
    force = std::move(rivals[named].force);
    events = std::move(rivals[named].events);
    robot.verdict = robot.alternatives.empty() ? verdict::named : verdict::one_of;
    robot.force_decided = true;
}

} // namespace berth
