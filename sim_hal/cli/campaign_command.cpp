#include "commands.h"
#include "python_script.h"

namespace berth
{

int campaign_command(const campaign_arguments &arguments)
{
    std::vector<std::string> words = {arguments.file};
    const auto add = [&](const std::string &name, const std::string &value) {
        if (!value.empty()) {
            words.insert(words.end(), {name, value});
        }
    };
    if (!arguments.folder.empty()) {
        words.push_back(arguments.folder);
    }
    add("--out", arguments.out_folder);
    add("--scheduler", arguments.scheduler);
    add("--workers", arguments.workers > 0 ? std::to_string(arguments.workers) : "");
    for (const auto &[name, is_set] : {std::pair("--resume", arguments.resume), std::pair("--yes", arguments.yes),
                                       std::pair("--anew", arguments.anew), std::pair("--slurm", arguments.slurm)}) {
        if (is_set) {
            words.emplace_back(name);
        }
    }
    become_module("berth.campaign", words);
}

} // namespace berth
