#include <algorithm>
#include <CLI/CLI.hpp>
#include <cstdio>

#include "../../hal/rig/names.h"
#include "commands.h"
#include "completion.h"
#include "man_page.h"

namespace berth
{

int completion_command(const CLI::App &app, const std::string &shell)
{
    std::fputs(completion(shell, command_table(app)).c_str(), stdout);
    return 0;
}

int man_command(const CLI::App &app, const std::string &name)
{
    const std::vector<command_entry> table = command_table(app);
    if (name.empty()) {
        std::fputs(man_page(table).c_str(), stdout);
        return 0;
    }
    const auto found =
        std::find_if(table.begin(), table.end(), [&](const auto &command) { return command.name == name; });
    if (found == table.end()) {
        const std::vector<std::string> pages = names_of(table);
        std::string message = name + ": there is no such manual page; there are";
        for (const std::string &page : pages) {
            message += (page == pages.front() ? " " : ", ") + page;
        }
        throw input_error(message + did_you_mean(pages, name));
    }
    std::fputs(man_page(*found).c_str(), stdout);
    return 0;
}

} // namespace berth
