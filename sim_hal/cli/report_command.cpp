#include <filesystem>

#include "commands.h"
#include "python_script.h"
#include "run_folder.h"

namespace berth
{

int report_command(const report_arguments &arguments)
{
    const std::string log = log_of(arguments.log);
    std::vector<std::string> words = {log};
    if (!arguments.accuracy_file.empty()) {
        words.insert(words.end(), {"--accuracy", arguments.accuracy_file});
    }
    if (!arguments.page.empty()) {
        if (std::filesystem::path(arguments.page).extension() != ".html") {
            throw input_error(arguments.page + ": --out writes a page for a browser: let its name end in .html");
        }
        words.insert(words.end(), {"--out", arguments.page});
    }
    const int exit_code = run_script("report.py", "report: " + log, words);
    if (arguments.page.empty()) {
        refresh_run_index(log);
    }
    return exit_code;
}

} // namespace berth
