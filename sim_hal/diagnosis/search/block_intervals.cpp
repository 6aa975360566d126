#include <algorithm>
#include <cmath>

#include "../../solver/manipulator_steps.h"
#include "block_search.h"

namespace berth
{

namespace
{

/* Known well enough to start from. An angle has no size of its own, its whole turn is; a clock's phase is known by
 * the ticks at which it slips, whatever its share in the dead time. */
bool is_known(std::string_view path, double value, double sd)
{
    const bool is_angle = path.size() > 4 && path.substr(path.size() - 4) == "_rad";
    return path == "robot.clock_phase_ms" || sd < 0.1 * std::max(std::abs(value), is_angle ? 1.0 : 0.0);
}

} // namespace

bool block_search::is_of_our_steps(block_model &model) const
{
    if (model.which() != block::manipulator) {
        return false;
    }
    const rig nothing;
    rig without = incumbent_.rig;
    double precision = 0.0;
    for (const effect &known : effect_library()) {
        if (known.on_body != nullptr && known.block() == "manipulator" && is_active(known, incumbent_.rig)) {
            precision = std::max({precision, steps_exact, known.precision});
            for (const effect_parameter &parameter : known.parameters) {
                set_number(without, parameter.key, value_of(nothing, parameter.key));
            }
        }
    }
    std::vector<double> before;
    std::vector<double> left;
    model.error(without, before);
    model.error(incumbent_.rig, left);
    /* On a record that was not fitted the steps are off by themselves, and by what the fit took them for. */
    const double replays = &model == &model_ ? 1.0 : 2.0;
    return rms_of(left, model.uses(), row_use::fit) <
           std::sqrt(replays) * precision * rms_of(before, model.uses(), row_use::fit);
}

void block_search::widen_by_our_steps()
{
    if (model_.which() != block::manipulator || found_.empty()) {
        return;
    }
    for (std::size_t i = 0; i < incumbent_.ci95.size(); i++) {
        const double value = value_of(incumbent_.rig, std::string(incumbent_.parameters[i].key->path));
        incumbent_.ci95[i] = std::hypot(incumbent_.ci95[i], steps_exact * value);
    }
}

void block_search::widen_by_what_is_left()
{
    for (std::size_t i = 0; i < incumbent_.ci95_if_slow.size(); i++) {
        incumbent_.ci95[i] = std::max(incumbent_.ci95[i], incumbent_.ci95_if_slow[i]);
    }
}

std::vector<free_parameter> block_search::refinable() const
{
    std::vector<bool> kept;
    for (std::size_t i = 0; i < incumbent_.ci95.size(); i++) {
        const rig_key *const key = incumbent_.parameters[i].key;
        const double sd = incumbent_.ci95[i] / 1.96;
        const bool is_rough = std::any_of(found_.begin(), found_.end(), [&](const effect *found) {
            return found->is_rough && found->parameters[0].key == key->path;
        });
        kept.push_back(sd > 0.0 && !is_rough && is_known(key->path, value_of(incumbent_.rig, key->path), sd));
    }
    return as_known(incumbent_, kept);
}

} // namespace berth
