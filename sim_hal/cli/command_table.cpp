#include "command_table.h"

#include <CLI/CLI.hpp>
#include <set>
#include <sstream>

#include "../../hal/rig/arm_file.h"
#include "../../hal/rig/commissioning.h"
#include "../../hal/rig/keys.h"
#include "../../hal/rig/names.h"
#include "../../hal/rig/robot_file.h"
#include "../diagnosis/diagnosis.h"
#include "compensation_choice.h"

namespace berth
{

namespace
{

/* "one, two" -> its words. */
std::vector<std::string> split_words(std::string text)
{
    for (char &c : text) {
        c = c == ',' ? ' ' : c;
    }
    std::istringstream stream(text);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) {
        words.push_back(word);
    }
    return words;
}

bool is_number(const rig_key &key)
{
    return key.type == key_type::number || key.type == key_type::integer;
}

/* A value is put behind: robot.dead_time_ms= */
std::vector<std::string> known_settings(bool only_numbers)
{
    std::vector<std::string> words;
    for (const rig_key &key : rig_keys()) {
        if (is_number(key) || !only_numbers) {
            words.push_back(std::string(key.path) + "=");
        }
    }
    return words;
}

/* object.kind=spring: of keys that do not take just any value. */
std::vector<std::string> known_values()
{
    std::vector<std::string> words;
    for (const rig_key &key : rig_keys()) {
        for (const std::string_view choice : key.choices) {
            words.push_back(std::string(key.path) + "=" + std::string(choice));
        }
        if (key.type == key_type::boolean) {
            words.push_back(std::string(key.path) + "=true");
            words.push_back(std::string(key.path) + "=false");
        }
    }
    return words;
}

std::vector<std::string> known_effects()
{
    std::vector<std::string> names;
    for (const effect &known : effect_library()) {
        names.emplace_back(known.name);
    }
    return names;
}

/* What is called so in the help is a file or a folder. */
bool is_file(const std::string &value)
{
    static const std::set<std::string> values = {"FILE", "FILE.html", "JSON", "DIR"};
    return values.count(value) > 0;
}

/* What names something that the program knows and reads from files as well. */
bool names_a_file_too(const std::string &name)
{
    static const std::set<std::string> names = {"RIG", "--rig", "NAME", "--robot", "ARM", "--arm", "LOG", "A"};
    return names.count(name) > 0;
}

/* What names something that the program knows. */
std::vector<std::string> known_words(const std::string &name)
{
    if (name == "RIG" || name == "--rig" || name == "LOG" || name == "A") { /* of a log: the rig's newest run */
        return names_of_files(shipped_rigs());
    }
    if (name == "NAME" || name == "--robot") {
        return names_of_files(shipped_robots());
    }
    if (name == "ARM" || name == "--arm") {
        return names_of_files(shipped_arms());
    }
    if (name == "--with") {
        return split_words(compensation_names());
    }
    if (name == "--vary") {
        return {"elasticity", "mass"};
    }
    if (name == "--model") {
        return {"point", "rig", "tolerances"};
    }
    if (name == "--without") {
        return known_effects();
    }
    if (name == "--stage" || name == "--waive") {
        return {stage_names.begin(), stage_names.end()};
    }
    if (name == "--case") {
        return {"1", "2", "3", "4"};
    }
    return name == "--set" || name == "--x" || name == "--y" ? known_settings(name != "--set")
                                                             : std::vector<std::string>();
}

option_entry entry_of(const CLI::Option &option)
{
    option_entry entry;
    entry.name = option.get_positional() ? option.get_name(true) : "--" + option.get_lnames().front();
    entry.meaning = option.get_description();
    entry.is_needed = option.get_required();
    entry.standard = option.get_default_str();
    if (option.get_items_expected_max() > 0) {
        entry.value = option.get_type_name();
        if (const std::size_t brace = entry.value.find('{'); brace != std::string::npos) { /* "TEXT:{one,two}" */
            entry.words = split_words(entry.value.substr(brace + 1, entry.value.find('}') - brace - 1));
            entry.value = "WORD";
        }
        entry.value = entry.value.substr(0, entry.value.find(':'));
    }
    if (entry.words.empty()) {
        entry.words = known_words(entry.name);
    }
    if (entry.name == "--set") {
        entry.values = known_values();
    }
    entry.takes_files = (entry.is_positional() && !entry.value.empty() && entry.words.empty()) ||
                        is_file(entry.value) || names_a_file_too(entry.name);
    return entry;
}

} // namespace

std::vector<std::string> names_of(const std::vector<command_entry> &table)
{
    std::vector<std::string> names;
    names.reserve(table.size());
    for (const command_entry &entry : table) {
        names.push_back(entry.name);
    }
    return names;
}

std::vector<command_entry> command_table(const CLI::App &app)
{
    std::vector<command_entry> table;
    for (const CLI::App *const command : app.get_subcommands(nullptr)) {
        command_entry entry{command->get_name(), command->get_description(), {}};
        for (const CLI::Option *const option : command->get_options()) {
            if (option->get_positional() || !option->get_lnames().empty()) {
                entry.options.push_back(entry_of(*option));
            }
        }
        table.push_back(std::move(entry));
    }
    for (command_entry &entry : table) {
        for (option_entry &option : entry.options) {
            if (option.name == "COMMAND") {
                option.words = names_of(table);
                option.takes_files = false;
            }
        }
    }
    return table;
}

} // namespace berth
