#include "commands.h"
#include "python_script.h"
#include "run_folder.h"

namespace berth
{

int report_command(const report_arguments &arguments)
{
    std::vector<std::string> words = {arguments.log};
    if (!arguments.accuracy_file.empty()) {
        words.insert(words.end(), {"--accuracy", arguments.accuracy_file});
    }
    const int exit_code = run_script("report.py", "report: " + arguments.log, words);
    refresh_run_index(arguments.log);
    return exit_code;
}

} // namespace berth
