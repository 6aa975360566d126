#include "described.h"

#include "../../hal/rig/given.h"

namespace berth
{

std::string_view missing_section(const record &data, const rig &given, block which)
{
    const bool has_robot = states_section(given, "robot");
    switch (which) {
    case block::manipulator:
        return states_section(given, "manipulator") ? "" : "manipulator";
    case block::robot:
        return has_robot ? "" : "robot";
    default:
        return !states_section(given, "object")              ? "object"
               : !has_robot && data.robot_position_m.empty() ? "robot"
                                                             : "";
    }
}

void tell_not_described(diagnosis &result, block which, std::string_view section)
{
    result.not_described.push_back(which);
    result.notes.push_back("the " + std::string(block_names[static_cast<int>(which)]) +
                           " is not judged: the rig does not describe it; state the section [" +
                           std::string(section) +
                           "], or base = \"ess\" as the first line, which takes the reference case on purpose");
}

} // namespace berth
