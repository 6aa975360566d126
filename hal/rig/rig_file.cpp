#include "rig_file.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

#define TOML_EXCEPTIONS 1
#include <toml++/toml.h>

#include "keys.h"

namespace berth
{

namespace
{

using key_places = std::map<std::string, std::string, std::less<>>; /* key path -> "file:line" */

std::string place(const std::string &origin, const toml::source_region &source)
{
    return origin + ":" + std::to_string(source.begin.line);
}

[[noreturn]] void fail(const std::string &where, const rig_error &error)
{
    throw input_error(where + ": " + error.key + ": " + error.message);
}

std::string text_of(const toml::node &value)
{
    std::ostringstream text;
    if (const auto *string = value.as_string()) {
        text << '"' << string->get() << '"';
    } else if (const auto *integer = value.as_integer()) {
        text << integer->get();
    } else if (const auto *number = value.as_floating_point()) {
        char digits[32];
        const auto [end, error] = std::to_chars(digits, digits + sizeof digits, number->get());
        text << std::string(digits, end);
    } else if (const auto *boolean = value.as_boolean()) {
        text << (boolean->get() ? "true" : "false");
    } else {
        text << value.type();
    }
    return text.str();
}

bool type_fits(const rig_key &key, const toml::node &value)
{
    switch (key.type) {
    case key_type::boolean:
        return value.is_boolean();
    case key_type::choice:
    case key_type::text:
        return value.is_string();
    default:
        return value.is_number();
    }
}

void read_value(rig &rig, const std::string &path, const toml::node &value, const std::string &where)
{
    const rig_key *key = find_key(path);
    if (key != nullptr && !type_fits(*key, value)) {
        static const char *const expected[] = {"a number", "a whole number", "true or false", "a word in quotes",
                                               "text in quotes"};
        fail(where, {path, std::string("must be ") + expected[static_cast<int>(key->type)] + " (is " +
                               text_of(value) + ")"});
    }
    if (const auto error = set_value(rig, path, text_of(value))) {
        fail(where, *error);
    }
}

bool is_file_name(std::string_view name)
{
    constexpr std::size_t bytes_max = 100;
    return name.size() <= bytes_max && name.substr(0, 1) != "." && name.find('/') == std::string_view::npos &&
           std::none_of(name.begin(), name.end(), is_control);
}

void read_top_level(rig &rig, const std::string &name, const toml::node &value, const std::string &where)
{
    std::string *member = name == "name" ? &rig.name : name == "description" ? &rig.description : nullptr;
    if (member == nullptr) {
        fail(where, {name, "unknown key; keys stand in a section, the nearest known one is " +
                               std::string(nearest_key(name))});
    }
    if (!value.is_string()) {
        fail(where, {name, "must be text in quotes"});
    }
    *member = value.as_string()->get();
    if (const auto error = text_error(*member)) {
        fail(where, {name, *error});
    }
    if (member == &rig.name && !is_file_name(rig.name)) {
        fail(where,
             {name, "names the log file: it must have at most 100 bytes, no \"/\" and no control characters, and "
                    "must not start with \".\""});
    }
}

bool is_known_section(std::string_view name)
{
    const auto &keys = rig_keys();
    return std::any_of(keys.begin(), keys.end(),
                       [&](const rig_key &key) { return key.path.substr(0, key.path.find('.')) == name; });
}

void read_table(rig &rig, const toml::table &table, const std::string &origin, key_places &places)
{
    for (const auto &[name, value] : table) {
        const std::string section(name.str());
        if (const auto *entries = value.as_table()) {
            for (const auto &[entry, entry_value] : *entries) {
                const std::string path = section + "." + std::string(entry.str());
                const std::string where = place(origin, entry.source());
                read_value(rig, path, entry_value, where);
                places[path] = where;
            }
            if (!is_known_section(section)) { /* empty, or its keys would have been unknown */
                const std::string_view nearest = nearest_key(section + ".");
                fail(place(origin, name.source()), {section, "unknown section; the nearest known one is " +
                                                                 std::string(nearest.substr(0, nearest.find('.')))});
            }
        } else {
            read_top_level(rig, section, value, place(origin, name.source()));
        }
    }
}

void apply_overrides(rig &rig, const std::vector<std::string> &overrides, key_places &places)
{
    for (const std::string &override : overrides) {
        const std::size_t equals = override.find('=');
        if (equals == std::string::npos) {
            throw input_error("--set " + override + ": must look like section.key=value");
        }
        const std::string path = override.substr(0, equals);
        const std::string where = "--set " + override;
        if (const auto error = set_value(rig, path, override.substr(equals + 1))) {
            fail(where, *error);
        }
        places[path] = where;
    }
}

std::string names_of_shipped_rigs()
{
    std::string names;
    for (const auto &shipped : shipped_rigs()) {
        names += (names.empty() ? "" : ", ") + std::string(shipped.name);
    }
    return names;
}

} // namespace

std::string read_file(const std::string &path)
{
    std::ifstream file(path, std::ios::binary);
    const bool is_empty = file.peek() == std::ifstream::traits_type::eof() && file.eof() && !file.bad();
    std::ostringstream text;
    if (!is_empty) {
        text << file.rdbuf();
    }
    if (!file.is_open() || file.bad() || text.fail()) {
        throw input_error(path + ": cannot be read; is it a file?");
    }
    return text.str();
}

rig parse_rig(const std::string &text, const std::string &origin, const std::vector<std::string> &overrides)
{
    rig rig;
    key_places places;
    try {
        read_table(rig, toml::parse(text, origin), origin, places);
    } catch (const toml::parse_error &error) {
        throw input_error(place(origin, error.source()) + ": " + std::string(error.description()));
    }
    apply_overrides(rig, overrides, places);
    if (const auto error = complete_and_check(rig)) {
        const auto found = places.find(error->key);
        fail(found == places.end() ? origin + " (default value)" : found->second, *error);
    }
    return rig;
}

rig load_rig(const std::string &name_or_path, const std::vector<std::string> &overrides)
{
    for (const auto &shipped : shipped_rigs()) {
        if (name_or_path == shipped.name) {
            return parse_rig(shipped.text, name_or_path + ".toml", overrides);
        }
    }
    const bool looks_like_path =
        name_or_path.find('/') != std::string::npos || name_or_path.find(".toml") != std::string::npos;
    if (!looks_like_path && !std::ifstream(name_or_path)) {
        throw input_error(name_or_path + ": no shipped rig has this name (" + names_of_shipped_rigs() +
                          ") and there is no such file");
    }
    rig rig = parse_rig(read_file(name_or_path), name_or_path, overrides);
    if (rig.name.empty()) {
        const std::size_t slash = name_or_path.rfind('/');
        const std::string file = slash == std::string::npos ? name_or_path : name_or_path.substr(slash + 1);
        rig.name = file.substr(0, file.rfind('.'));
        if (!is_file_name(rig.name)) {
            throw input_error(name_or_path +
                              ": its name cannot name the log; give the rig another with name = \"...\"");
        }
    }
    return rig;
}

std::string print_rig(const rig &rig)
{
    std::ostringstream text;
    text << "name = " << quoted(rig.name) << "\n";
    text << "description = " << quoted(rig.description) << "\n";
    std::string section;
    for (const rig_key &key : rig_keys()) {
        const std::size_t dot = key.path.find('.');
        if (key.path.substr(0, dot) != section) {
            section = key.path.substr(0, dot);
            text << "\n[" << section << "]\n";
        }
        std::string line = std::string(key.path.substr(dot + 1)) + " = " + value_text(rig, key);
        line.resize(std::max<std::size_t>(line.size(), 50), ' ');
        text << line << " # " << key.meaning << "\n";
    }
    return text.str();
}

std::string config_hash(const rig &rig)
{
    return text_hash(print_rig(rig));
}

std::string text_hash(std::string_view bytes)
{
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (const char c : bytes) {
        hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
    }
    char text[17];
    std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
    return text;
}

} // namespace berth
