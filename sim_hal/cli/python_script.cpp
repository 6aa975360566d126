#include "python_script.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>

#include "../../hal/rig/rig_file.h"
#include "progress_line.h"

namespace berth
{

namespace
{

constexpr int exit_broken_pipe = 128 + SIGPIPE; /* as shells have it */

/* Of the repository in which the program was built: it stands in build/ there, or in a folder of build/. */
std::filesystem::path repository(const std::string &script)
{
    std::error_code error;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
    for (std::filesystem::path at = program.parent_path(); at != at.parent_path(); at = at.parent_path()) {
        if (std::filesystem::exists(at / "scripts" / script, error)) {
            return at;
        }
    }
    throw input_error("scripts/" + script +
                      ": is not there. Scripts of berth's repository draw pages and pictures; " + program.string() +
                      " looks for them in " + (program.parent_path() / "scripts").string() +
                      " and in the same way in each folder above. Call build/berth of the repository, or replace "
                      "this copy by a link to it (ln -sf REPOSITORY/build/berth " +
                      program.string() + ")");
}

} // namespace

int run_script(const std::string &name, const std::string &doing, const std::vector<std::string> &arguments)
{
    const std::filesystem::path top = repository(name);
    const std::string python = (top / ".venv" / "bin" / "python").string();
    if (access(python.c_str(), X_OK) != 0) {
        throw input_error(python +
                          ": the Python environment is missing, which draws pages and pictures; `make setup` in " +
                          top.string() + " makes it");
    }
    std::vector<std::string> words = {python, (top / "scripts" / name).string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char *> argv;
    argv.reserve(words.size() + 1);
    for (std::string &word : words) {
        argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    std::fflush(stdout);
    const progress_line progress;
    progress.show(doing);
    const pid_t child = fork();
    if (child == 0) {
        execv(argv[0], argv.data());
        _exit(127);
    }
    int status = 0;
    const bool has_ended = child > 0 && waitpid(child, &status, 0) == child;
    if (has_ended && WIFSIGNALED(status) && WTERMSIG(status) == SIGPIPE) {
        return exit_broken_pipe; /* nobody reads on, as behind `| head` */
    }
    if (!has_ended || !WIFEXITED(status)) {
        throw input_error(words[1] + ": could not be run to its end");
    }
    return WEXITSTATUS(status);
}

} // namespace berth
