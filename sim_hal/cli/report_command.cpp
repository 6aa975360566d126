#include <filesystem>

#include "commands.h"
#include "python_script.h"
#include "run_folder.h"

namespace berth
{

namespace
{

/* A folder that `berth diagnose --out` wrote. */
bool holds_diagnosis(const std::string &folder)
{
    std::error_code error;
    return std::filesystem::exists(std::filesystem::path(folder) / "diagnosis.json", error);
}

int report_of_diagnosis(const report_arguments &arguments)
{
    if (!arguments.accuracy_file.empty() || arguments.no_poses || !arguments.page.empty()) {
        throw input_error(arguments.log + ": is a diagnosis: its report goes beside it, and takes no options");
    }
    return run_script("diagnosis_report.py", "report: " + arguments.log, {arguments.log});
}

} // namespace

int report_command(const report_arguments &arguments)
{
    if (holds_diagnosis(arguments.log)) {
        return report_of_diagnosis(arguments);
    }
    const std::string log = log_of(arguments.log);
    std::vector<std::string> words = {log};
    if (!arguments.accuracy_file.empty()) {
        words.insert(words.end(), {"--accuracy", arguments.accuracy_file});
    }
    if (arguments.no_poses) {
        words.emplace_back("--no-poses");
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
