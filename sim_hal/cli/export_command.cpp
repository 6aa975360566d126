#include "../../hal/rig/rig_file.h"
#include "../log/ulog_reader.h"
#include "commands.h"
#include "python_script.h"
#include "run_folder.h"

namespace berth
{

/* A script writes the files: the libraries for Parquet and MCAP are Python's. */
int export_command(const export_arguments &arguments)
{
    if (!arguments.csv && !arguments.parquet && !arguments.mcap) {
        throw input_error("export: says no format; give --csv, --parquet or --mcap, or several of them");
    }
    const std::string log = log_of(arguments.log);
    const ulog_reader readable(log); /* refuses a log that cannot be read, before Python is started */
    if (const auto &damage = readable.condition().damage) {
        throw input_error(log + ": " + text_of(*damage));
    }
    std::vector<std::string> words = {log};
    for (const auto &[is_wanted, word] :
         {std::pair(arguments.csv, "--csv"), {arguments.parquet, "--parquet"}, {arguments.mcap, "--mcap"}}) {
        if (is_wanted) {
            words.emplace_back(word);
        }
    }
    return run_script("export_log.py", "export: " + log, words);
}

} // namespace berth
