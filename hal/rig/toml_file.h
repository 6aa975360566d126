/* What rig files and robot presets have in common: TOML whose every value knows its file and line. Only for the
 * files that read them: it brings the parser in. */
#ifndef HAL_RIG_TOML_FILE_H
#define HAL_RIG_TOML_FILE_H

#include <map>
#include <string>

/* Inputs at which the parser's own checks stop it, such as a line of "[" alone: an error of the file, no abort. */
struct toml_check_failed {
};
[[noreturn]] inline void fail_toml_check()
{
    throw toml_check_failed{};
}
#define TOML_ASSERT(condition) ((condition) ? static_cast<void>(0) : fail_toml_check())
#define TOML_EXCEPTIONS 1
#include <toml++/toml.h>

#include "rig.h"

namespace berth
{

/* Where each key got its value: key path -> "file:line" or the option that set it. */
using key_places = std::map<std::string, std::string, std::less<>>;

toml::table parse_toml(const std::string &text, const std::string &origin);

/* "file:line" */
std::string place(const std::string &origin, const toml::source_region &source);

[[noreturn]] void fail(const std::string &where, const rig_error &error);

/* A value as it stands in the file. */
std::string text_of(const toml::node &value);

/* With as many digits as tell it from its neighbours. */
std::string number_text(double value);

/* With commas between. */
template <typename Names>
std::string list_of(const Names &names)
{
    std::string list;
    for (const auto &name : names) {
        list.append(list.empty() ? "" : ", ").append(name);
    }
    return list;
}

/* Throws input_error for anything else. */
double finite_number(const std::string &key, const toml::node &node, const std::string &origin);

/* Sets a key of the rig; refuses a value of the wrong type or out of range. */
void read_value(rig &rig, const std::string &path, const toml::node &value, const std::string &where);

/* Text in quotes, of bearable length. */
std::string read_text(const std::string &key, const toml::node &value, const std::string &where);

/* A word that may name a file. */
std::string read_file_name(const std::string &key, const toml::node &value, const std::string &where);
bool is_file_name(std::string_view name);

/* "folder/my-rig.toml" -> "my-rig" */
std::string stem_of(const std::string &path);

/* A path rather than the name of something shipped. */
bool looks_like_path(const std::string &name_or_path);

/* The line on which XML begins, as URDF is: TOML begins with a key, a section or a comment. 0: it is none. */
std::int64_t line_of_xml(const std::string &text);

} // namespace berth

#endif
