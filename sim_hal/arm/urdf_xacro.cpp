#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "../../hal/rig/rig_file.h"
#include "urdf.h"

extern char **environ;

namespace berth
{

namespace
{

constexpr int exit_not_found = 127; /* of posix_spawn where it reports so late */

struct closing {
    void operator()(std::FILE *file) const { (void)std::fclose(file); }
};
using open_file = std::unique_ptr<std::FILE, closing>;

open_file temporary()
{
    open_file file(std::tmpfile());
    if (file == nullptr) {
        throw input_error("no temporary file for what xacro prints: " + std::string(std::strerror(errno)));
    }
    return file;
}

std::string all_of(std::FILE *file)
{
    std::string text;
    std::rewind(file);
    char part[4096];
    for (std::size_t size = 0; (size = std::fread(part, 1, sizeof part, file)) > 0;) {
        text.append(part, size);
    }
    return text;
}

/* On one line: xacro states the cause first, and then where it was on the way to it. */
std::string on_one_line(const std::string &text)
{
    std::string line;
    for (const char c : text) {
        if (c != '\n') {
            line += c;
        } else if (!line.empty() && line.back() != ' ') {
            line += ' ';
        }
    }
    return line.substr(0, line.find_last_not_of(' ') + 1);
}

[[noreturn]] void fail_not_installed(const std::string &path)
{
    throw input_error(path +
                      ": needs the program xacro, which is not installed: `pip install xacro`, or expand it "
                      "where there is one, with `xacro " +
                      path + " > ROBOT.urdf`");
}

} // namespace

std::string expand_xacro(const std::string &path)
{
    (void)read_file(path); /* says what is wrong where it cannot be read */
    const open_file out = temporary();
    const open_file err = temporary();
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, fileno(out.get()), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fileno(err.get()), STDERR_FILENO);
    std::string program = "xacro";
    std::string file = path[0] == '-' ? "./" + path : path; /* no option */
    char *const words[] = {program.data(), file.data(), nullptr};
    pid_t child = 0;
    const int failed = posix_spawnp(&child, program.c_str(), &actions, nullptr, words, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed == ENOENT) {
        fail_not_installed(path);
    }
    int status = 0;
    if (failed != 0 || waitpid(child, &status, 0) != child) {
        throw input_error(path + ": xacro cannot be run: " + std::strerror(failed != 0 ? failed : errno));
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == exit_not_found) {
        fail_not_installed(path);
    }
    if (status != 0) {
        throw input_error(path + ": xacro fails: " + on_one_line(all_of(err.get())) +
                          "; what it needs, such as arguments or packages of ROS, it gets with `xacro " + path +
                          " NAME:=VALUE > ROBOT.urdf`");
    }
    return all_of(out.get());
}

} // namespace berth
