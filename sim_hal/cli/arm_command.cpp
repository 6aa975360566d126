#include <cstdio>
#include <nlohmann/json.hpp>

#include "../../hal/rig/arm_file.h"
#include "../arm/arm_at_states.h"
#include "../arm/urdf.h"
#include "commands.h"

namespace berth
{

namespace
{

bool ends_with(const std::string &text, const std::string &end)
{
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

arm_description read_arm(const arm_arguments &arguments)
{
    if (ends_with(arguments.arm, ".urdf")) {
#ifdef BERTH_WITH_URDF
        return arm_from_urdf(read_file(arguments.arm), arguments.arm,
                             {arguments.base, arguments.tool, arguments.is_planar});
#else
        throw input_error(arguments.arm +
                          ": this program was built without URDF; make an arm file of it by one that "
                          "was, such as the host's");
#endif
    }
    if (!arguments.base.empty() || !arguments.tool.empty() || arguments.is_planar) {
        throw input_error(arguments.arm + ": --base, --tool and --planar are for URDF files");
    }
    return load_arm(arguments.arm);
}

} // namespace

int arm_command(const arm_arguments &arguments)
{
    const arm_description arm = read_arm(arguments);
    if (arguments.states_file.empty()) {
        std::fputs(print_arm(arm).c_str(), stdout);
        return 0;
    }
    nlohmann::json states;
    try {
        states = nlohmann::json::parse(read_file(arguments.states_file));
    } catch (const nlohmann::json::parse_error &error) {
        throw input_error(arguments.states_file + ": not JSON, at byte " + std::to_string(error.byte));
    } catch (const nlohmann::json::out_of_range &) {
        throw input_error(arguments.states_file + ": has a number that is too large");
    }
    std::printf("%s\n", arm_at_states(arm.config, states, arguments.states_file).dump().c_str());
    return 0;
}

} // namespace berth
