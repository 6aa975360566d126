#include "switch_beside_losses.h"

#include <algorithm>
#include <cmath>

#include "../../effects/active.h"
#include "../fit/base.h"
#include "../noise/floor.h"
#include "loss_finder.h"

namespace berth
{

namespace
{

constexpr std::string_view switches[] = {"robot.deadband", "robot.velocity_limit", "robot.acceleration_limit"};

/* A round of the search: this many ticks of motion are decoded at sizes up to `factor` times as large or small. */
struct zoom {
    std::size_t ticks;
    double factor;
    int sizes;
};
constexpr zoom zooms[] = {{1000, 2.0, 41}, {3000, 1.05, 21}, {6000, 1.006, 13}};

constexpr double left_max = 0.3; /* of the squares: else it is not this */

struct sized {
    berth::rig rig;
    double cost = std::numeric_limits<double>::infinity();
    double share_left = 1.0;
    std::vector<std::uint8_t> lost = {};
};

class size_finder
{
  public:
    size_finder(const diagnosis_input &input, const rig &given, const effect &effect)
        : input_(input), given_(given), key_(effect.parameters[0].key)
    {
    }

    /* From a rig that has a first size. */
    sized find(const rig &first)
    {
        sized best{first};
        acts_at_ = acts_at(first);
        for (const zoom &now : zooms) {
            if (&now != zooms && best.share_left > left_max) {
                break;
            }
            const rig start = tuned(best);
            const double middle = value_of(start, key_);
            best.cost = std::numeric_limits<double>::infinity();
            for (int i = 0; i < now.sizes; i++) {
                const double share = 2.0 * i / (now.sizes - 1) - 1.0;
                rig rig = start;
                set_number(rig, key_, middle * std::pow(now.factor, share));
                sized made = decoded(rig, now.ticks);
                if (made.cost < best.cost) {
                    best = std::move(made);
                }
            }
        }
        return best;
    }

  private:
    /* Where the robot begins to go otherwise than it is told. */
    std::size_t acts_at(const rig &rig) const
    {
        constexpr double begins = 0.01; /* of the most */
        const std::vector<double> &sent_m = input_.fit->command_position_m;
        driven_path path(rig, *input_.fit);
        std::vector<double> off_m;
        off_m.reserve(sent_m.size());
        for (const double at_m : sent_m) {
            off_m.push_back(std::abs(path.take(at_m) - at_m));
        }
        const double most_m = *std::max_element(off_m.begin(), off_m.end());
        const auto first =
            std::find_if(off_m.begin(), off_m.end(), [&](double way_m) { return way_m >= begins * most_m; });
        return static_cast<std::size_t>(first - off_m.begin());
    }

    /* The base, with the losses that are known; before any are, as it is. */
    rig tuned(const sized &at) const
    {
        if (at.lost.empty()) {
            return at.rig;
        }
        const sized whole = decoded(at.rig, input_.fit->size());
        sample_events events;
        events.lost_command = whole.lost;
        block_model model(block::robot, *input_.fit, given_, events, held_out_parts::none);
        std::vector<double> error;
        model.error(at.rig, error);
        return fit(model, noise_of(model, error, true), at.rig, base_parameters(block::robot, given_),
                   input_.options.replays_max)
            .rig;
    }

    sized decoded(const rig &rig, std::size_t ticks) const
    {
        const sample_events none;
        block_model model(block::robot, *input_.fit, given_, none, held_out_parts::none);
        std::vector<double> error;
        model.error(rig, error);
        const std::size_t end = std::min(error.size(), acts_at_ + ticks);
        std::vector<row_use> uses = model.uses();
        std::fill(uses.begin() + static_cast<std::ptrdiff_t>(end), uses.end(), row_use::none);
        model.use(uses);
        const loss_trace loss = trace_of_loss(model, rig);
        const std::vector<std::uint8_t> nothing(error.size(), 0);
        loss_finder finder(model, rig, loss, error, nothing, 0);
        finder.decode_first(end);
        sized made{rig, finder.information(), finder.share_left(), finder.lost};
        made.lost.resize(input_.fit->size(), 0);
        return made;
    }

    const diagnosis_input &input_;
    const rig &given_;
    std::string_view key_;
    std::size_t acts_at_ = 0;
};

/* The given rig with the base that was tuned. */
rig base_of(const block_diagnosis &result, const rig &given)
{
    rig made = given;
    for (const free_parameter &base : base_parameters(block::robot, given)) {
        set_number(made, base.key->path, value_of(result.extended, base.key->path));
    }
    return made;
}

/* A first size: a limit's own, and of a dead band what would leave an error as large as there is. */
std::optional<double> first_size(const effect &effect, const block_diagnosis &result)
{
    for (const cause &known : result.causes) {
        if (known.effect == &effect) {
            return known.parameters[0].value;
        }
    }
    if (effect.name == "robot.deadband") {
        return std::sqrt(3.0) * result.fit_rms.retuned;
    }
    return {};
}

} // namespace

std::optional<rig> switch_beside_losses(const diagnosis_input &input, const rig &given,
                                        const block_diagnosis &result)
{
    std::optional<sized> best;
    for (const std::string_view name : switches) {
        const effect *const effect = find_effect(name);
        const auto size = first_size(*effect, result);
        const auto &without = input.options.without;
        if (!size || std::find(without.begin(), without.end(), name) != without.end()) {
            continue;
        }
        rig first = base_of(result, given);
        set_number(first, effect->parameters[0].key, *size);
        sized found = size_finder(input, given, *effect).find(first);
        if (found.share_left < left_max && (!best || found.cost < best->cost)) {
            best = std::move(found);
        }
    }
    return best ? std::optional<rig>(best->rig) : std::nullopt;
}

} // namespace berth
