#include <filesystem>

#include "commands.h"
#include "python_script.h"
#include "short_number.h"

namespace berth
{

int live_command(const live_arguments &arguments)
{
    if (arguments.what.empty() == arguments.source.empty()) {
        throw input_error("live: name a rig, a log, or --from ADDRESS of a target; one of them");
    }
    std::vector<std::string> words;
    const auto add = [&](const std::string &name, const std::string &value) {
        if (!value.empty()) {
            words.push_back(name + "=" + value);
        }
    };
    add("--from", arguments.source);
    add("--rig", arguments.rig);
    add("--robot", arguments.robot);
    for (const std::string &setting : arguments.overrides) {
        add("--set", setting);
    }
    add("--speed", short_number(arguments.speed));
    add("--bind", arguments.bind);
    add("--port", std::to_string(arguments.port));
    add("--plotjuggler", arguments.plotjuggler);
    add("--out", arguments.out_folder);
    if (arguments.end) {
        words.emplace_back("--end");
    }
    if (!arguments.what.empty()) {
        words.insert(words.end(), {"--", arguments.what});
    }
    become_module("berth.live", words);
}

} // namespace berth
