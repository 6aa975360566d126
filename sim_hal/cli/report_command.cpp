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
    const int exit_code = run_script("report.py", "report: " + log, words);
    refresh_run_index(log);
    return exit_code;
}

} // namespace berth
