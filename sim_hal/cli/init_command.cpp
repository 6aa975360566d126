#include <cctype>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "../../hal/rig/keys.h"
#include "../../hal/rig/rig_file.h"
#include "../../hal/rig/toml_file.h"
#include "atomic_file.h"
#include "commands.h"
#include "rig_schema.h"
#include "rig_template.h"

namespace berth
{

namespace
{

void write_and_name(const std::filesystem::path &path, const std::string &text)
{
    atomic_file file(path.string());
    file.write(text);
    file.finish();
    std::printf("%s\n", path.c_str());
}

/* A file's name as a word of a shell's command line, that no program takes for an option. */
std::string in_shell(const std::string &file)
{
    const std::string word = file.front() == '-' ? "./" + file : file;
    std::string text;
    bool is_plain = true;
    for (const char c : word) {
        is_plain =
            is_plain && (std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("._/-+,", c) != nullptr);
        text += c == '\'' ? "'\\''" : std::string(1, c);
    }
    return is_plain ? word : "'" + text + "'";
}

void refuse_missing_folder(const std::filesystem::path &file)
{
    const std::filesystem::path folder = file.parent_path();
    std::error_code error;
    if (folder.empty() || std::filesystem::is_directory(folder, error)) {
        return;
    }
    const bool is_there = std::filesystem::exists(folder, error);
    throw input_error(file.string() + ": the folder " + folder.string() +
                      (is_there ? " is a file; choose another name"
                                : " does not exist; make it with mkdir -p " + folder.string()));
}

} // namespace

int init_command(const init_arguments &arguments)
{
    const std::filesystem::path path = arguments.file;
    if (path.extension() != ".toml") {
        throw input_error(arguments.file + ": a rig file's name must end with .toml");
    }
    if (!arguments.force && std::ifstream(path)) {
        throw input_error(arguments.file + ": is there already, and stays as it is; --force overwrites it");
    }
    if (!is_file_name(path.stem().string())) {
        throw input_error(in_quotes(arguments.file) +
                          ": a file of this name would be no rig: its name is the rig's, and "
                          "names the files of its runs; choose another");
    }
    refuse_missing_folder(path);
    template_choice choice;
    choice.name = path.stem().string();
    choice.object = arguments.object;
    choice.sensor = arguments.sensor;
    if (!arguments.robot.empty()) {
        choice.robot = load_robot(arguments.robot);
    }
    write_and_name(path, rig_template(choice));
    write_and_name(path.parent_path() / rig_schema_file, rig_schema_text());
    std::printf("next: put in the values of your hardware, then berth check %s\n", in_shell(path.string()).c_str());
    return 0;
}

} // namespace berth
