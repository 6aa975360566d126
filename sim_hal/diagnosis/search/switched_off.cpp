#include "switched_off.h"

#include <algorithm>

namespace berth
{

rig switched_off(rig from, const std::vector<const effect *> &gone, const std::vector<free_parameter> &base,
                 const rig &given)
{
    for (const effect *const dropped : gone) {
        for (const effect_parameter &parameter : dropped->parameters) {
            const auto known = std::find_if(base.begin(), base.end(),
                                            [&](const auto &one) { return one.key->path == parameter.key; });
            const double value = value_of(from, parameter.key);
            set_number(from, parameter.key,
                       known == base.end() ? value_of(given, parameter.key)
                                           : std::min(std::max(value, known->low), known->high));
        }
        if (dropped->switch_on != nullptr) {
            from.robot.clock = given.robot.clock;
        }
    }
    return from;
}

std::vector<free_parameter> parameters_of_others(std::vector<free_parameter> all,
                                                 const std::vector<const effect *> &gone)
{
    const auto is_gone = [&](const free_parameter &free) {
        return std::any_of(gone.begin(), gone.end(), [&](const effect *dropped) {
            return std::any_of(dropped->parameters.begin(), dropped->parameters.end(),
                               [&](const effect_parameter &own) { return own.key == free.key->path; });
        });
    };
    all.erase(std::remove_if(all.begin(), all.end(), is_gone), all.end());
    return all;
}

} // namespace berth
