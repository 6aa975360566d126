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

std::filesystem::path own_program()
{
    std::error_code error;
    return std::filesystem::read_symlink("/proc/self/exe", error);
}

/* The repository in which the program was built, if it has this file: the program stands in build/ there, or in a
 * folder of build/. Else nothing. */
std::filesystem::path repository_with(const std::filesystem::path &file)
{
    std::error_code error;
    for (std::filesystem::path at = own_program().parent_path(); at != at.parent_path(); at = at.parent_path()) {
        if (std::filesystem::exists(at / file, error)) {
            return at;
        }
    }
    return {};
}

std::filesystem::path repository(const std::string &script)
{
    std::filesystem::path found = repository_with(std::filesystem::path("scripts") / script);
    if (!found.empty()) {
        return found;
    }
    const std::filesystem::path program = own_program();
    throw input_error("scripts/" + script +
                      ": is not there. Scripts of berth's repository draw pages and pictures; " + program.string() +
                      " looks for them in " + (program.parent_path() / "scripts").string() +
                      " and in the same way in each folder above. Call build/berth of the repository, or replace "
                      "this copy by a link to it (ln -sf REPOSITORY/build/berth " +
                      program.string() + ")");
}

/* As execvp wants them. */
std::vector<char *> pointers_to(std::vector<std::string> &words)
{
    std::vector<char *> argv;
    argv.reserve(words.size() + 1);
    for (std::string &word : words) {
        argv.push_back(word.data());
    }
    argv.push_back(nullptr);
    return argv;
}

/* Exit code of a program that is run to its end; 127: there is none. */
int exit_code_of(std::vector<std::string> words)
{
    const std::vector<char *> argv = pointers_to(words);
    const pid_t child = fork();
    if (child == 0) {
        execvp(argv[0], argv.data());
        _exit(127);
    }
    int status = 0;
    const bool has_ended = child > 0 && waitpid(child, &status, 0) == child;
    return has_ended && WIFEXITED(status) ? WEXITSTATUS(status) : 127;
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
    const std::vector<char *> argv = pointers_to(words);
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

void become_module(const std::string &module, const std::vector<std::string> &arguments)
{
    const std::filesystem::path python_path = ".venv/bin/python";
    const std::filesystem::path top = repository_with(python_path);
    const std::string python = top.empty() ? "python3" : (top / python_path).string();
    const std::string is_there = "import importlib.util, sys; sys.exit(not importlib.util.find_spec('berth'))";
    if (exit_code_of({python, "-c", is_there}) != 0) {
        throw input_error("the Python package of berth is missing for " + python + ": install it with " +
                          (top.empty() ? "`make wheel` in berth's repository and `pip install berth-*.whl`"
                                       : "`make python` in " + top.string()));
    }
    std::vector<std::string> words = {python, "-m", module};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::fflush(stdout);
    execvp(words[0].c_str(), pointers_to(words).data());
    throw input_error(python + ": could not be started");
}

} // namespace berth
