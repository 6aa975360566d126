#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "../../hal/rig/rig_file.h"
#include "../log/ulog_reader.h"
#include "commands.h"

namespace berth
{

namespace
{

/* The clone that this program was built in: build/berth. */
std::filesystem::path clone_of_program()
{
    std::error_code error;
    return std::filesystem::read_symlink("/proc/self/exe", error).parent_path().parent_path();
}

} // namespace

/* A script writes the files: the libraries for Parquet and MCAP are Python's. */
int export_command(const export_arguments &arguments)
{
    if (!arguments.csv && !arguments.parquet && !arguments.mcap) {
        throw input_error("export: says no format; give --csv, --parquet or --mcap, or several of them");
    }
    ulog_reader readable(arguments.log); /* throws before Python is asked */
    const std::filesystem::path clone = clone_of_program();
    const std::string python = clone / ".venv/bin/python";
    const std::string script = clone / "scripts/export_log.py";
    std::vector<const char *> words = {python.c_str(), script.c_str(), arguments.log.c_str()};
    for (const auto &[is_wanted, word] :
         {std::pair(arguments.csv, "--csv"), {arguments.parquet, "--parquet"}, {arguments.mcap, "--mcap"}}) {
        if (is_wanted) {
            words.push_back(word);
        }
    }
    words.push_back(nullptr);
    execv(python.c_str(), const_cast<char *const *>(words.data()));
    throw input_error(python + ": cannot be run (" + std::strerror(errno) +
                      "); `make setup` installs it, for a berth that was built in its clone");
}

} // namespace berth
