#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "../../hal/rig/arm_file.h"
#include "../arm/arm_at_states.h"
#include "../arm/urdf.h"
#include "commands.h"
#include "number.h"

namespace berth
{

namespace
{

bool ends_with(const std::string &text, const std::string &end)
{
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool is_urdf_or_xacro(const std::string &path)
{
    return ends_with(path, ".urdf") || ends_with(path, ".xacro");
}

#ifdef BERTH_WITH_URDF

urdf_hold hold_from(const std::string &word)
{
    const std::size_t equals = word.rfind('=');
    if (equals == std::string::npos) {
        return {word, std::nullopt};
    }
    const std::string text = word.substr(equals + 1);
    const char *end = nullptr;
    const double value = number_at<double>(text.c_str(), &end);
    if (text.empty() || *end != '\0' || !std::isfinite(value)) {
        throw input_error("--hold " + word + ": must be JOINT=VALUE, in rad or m, or JOINT alone");
    }
    return {word.substr(0, equals), value};
}

/* An arm, and what was chosen as comments of an arm file. */
arm_description read_urdf(const arm_arguments &arguments, std::string &comments)
{
    urdf_choice choice = {arguments.base, arguments.tool, arguments.is_planar, {}};
    for (const std::string &word : arguments.holds) {
        choice.holds.push_back(hold_from(word));
    }
    const bool is_xacro = ends_with(arguments.arm, ".xacro");
    const std::string text = is_xacro ? expand_xacro(arguments.arm) : read_file(arguments.arm, written_bytes_max);
    urdf_arm arm = arm_from_urdf(text, arguments.arm + (is_xacro ? " (as xacro expands it)" : ""), choice);
    for (const std::string &warning : arm.warnings) {
        std::fprintf(stderr, "berth: warning: %s\n", warning.c_str());
    }
    for (std::string note : arm.notes) {
        std::replace_if(
            note.begin(), note.end(), [](unsigned char c) { return std::iscntrl(c) != 0; }, ' ');
        comments += "# " + note + "\n";
    }
    return arm;
}

#else

arm_description read_urdf(const arm_arguments &arguments, std::string &)
{
    throw input_error(arguments.arm + ": this program was built without URDF; make an arm file of it by one that "
                                      "was, such as the host's");
}

#endif

arm_description read_arm(const arm_arguments &arguments, std::string &comments)
{
    if (is_urdf_or_xacro(arguments.arm)) {
        return read_urdf(arguments, comments);
    }
    if (!arguments.base.empty() || !arguments.tool.empty() || arguments.is_planar || !arguments.holds.empty()) {
        throw input_error(arguments.arm + ": --base, --tool, --hold and --planar are for URDF files");
    }
    return load_arm(arguments.arm);
}

} // namespace

int arm_command(const arm_arguments &arguments)
{
    std::string comments;
    const arm_description arm = read_arm(arguments, comments);
    if (arguments.states_file.empty()) {
        std::fputs((comments + print_arm(arm)).c_str(), stdout);
        return 0;
    }
    nlohmann::json states;
    try {
        states = nlohmann::json::parse(read_file(arguments.states_file, written_bytes_max));
    } catch (const nlohmann::json::parse_error &error) {
        throw input_error(arguments.states_file + ": not JSON, at byte " + std::to_string(error.byte));
    } catch (const nlohmann::json::out_of_range &) {
        throw input_error(arguments.states_file + ": has a number that is too large");
    }
    std::printf("%s\n", arm_at_states(arm.config, states, arguments.states_file).dump().c_str());
    return 0;
}

} // namespace berth
