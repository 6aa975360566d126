#include "rig_file.h"

#include <algorithm>
<<<<<<< HEAD
#include <charconv>
#include <cmath>
=======
#include <cstdio>
>>>>>>> main
#include <fstream>
#include <sstream>

#include "keys.h"
#include "robot_file.h"
#include "toml_file.h"

namespace berth
{

namespace
{

<<<<<<< HEAD
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

void set_tolerance(rig &rig, const std::string &path, const toml::node &share, const std::string &where)
{
    const rig_key *const key = find_key(path);
    if (key == nullptr) {
        fail(where, {path, "unknown key; the nearest known one is " + std::string(nearest_key(path))});
    }
    const double value = share.value<double>().value_or(-1.0);
    if (key->type != key_type::number || !(value >= 0.0 && value < 1.0)) {
        fail(where, {path, "its tolerance must be a share of it, from 0 to less than 1 (is " + text_of(share) + ")"});
    }
    rig.tolerances.push_back({path, value});
}

/* mass_kg = { value = 100, tolerance = 0.05 } */
const toml::node &split_tolerance(rig &rig, const std::string &path, const toml::node &node, const std::string &where)
{
    const toml::table *const table = node.as_table();
    if (table == nullptr) {
        return node;
    }
    for (const auto &[name, entry] : *table) {
        if (name.str() != "value" && name.str() != "tolerance") {
            fail(where, {path + "." + std::string(name.str()),
                         "unknown; a number may read { value = 100, tolerance = 0.05 }"});
        }
    }
    const toml::node *const value = table->get("value");
    if (value == nullptr) {
        fail(where, {path, "has no value; write { value = 100, tolerance = 0.05 }"});
    }
    if (const toml::node *const share = table->get("tolerance")) {
        set_tolerance(rig, path, *share, where);
    }
    return *value;
}

void read_signal(rig &rig, const std::string &name, const toml::node &node, const std::string &where)
{
    const std::string path = "signals." + name;
    if (std::find(signal_names.begin(), signal_names.end(), name) == signal_names.end()) {
        std::string message = "no signal of a record; there are";
        for (const auto known : signal_names) {
            message += (known == signal_names.front() ? " " : ", ") + std::string(known);
        }
        fail(where, {path, message});
    }
    signal_source source{name, "", 1.0, 0.0};
    if (const auto *column = node.as_string()) {
        source.column = column->get();
    } else if (const toml::table *const table = node.as_table()) {
        for (const auto &[entry, value] : *table) {
            const std::string key(entry.str());
            if (key == "column" && value.is_string()) {
                source.column = value.as_string()->get();
            } else if ((key == "scale" || key == "offset") && value.is_number()) {
                (key == "scale" ? source.scale : source.offset) = value.value<double>().value_or(0.0);
            } else {
                fail(where, {path + "." + key, "must be column = \"...\", scale = a number or offset = a number"});
            }
        }
    }
    if (source.column.empty()) {
        fail(where, {path, "names no column; write { column = \"vir_V\", scale = 35.15 }"});
    }
    if (!std::isfinite(source.scale) || source.scale == 0.0 || !std::isfinite(source.offset)) {
        fail(where, {path, "scale and offset must be finite numbers, and scale not 0"});
    }
    rig.signals.push_back(source);
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

=======
>>>>>>> main
void read_top_level(rig &rig, const std::string &name, const toml::node &value, const std::string &where)
{
    std::string *member = name == "name" ? &rig.name : name == "description" ? &rig.description : nullptr;
    if (member == nullptr) {
        fail(where, {name, "unknown key; keys stand in a section, the nearest known one is " +
                               std::string(nearest_key(name))});
    }
    *member = member == &rig.name ? read_file_name(name, value, where) : read_text(name, value, where);
}

void read_table(rig &rig, const toml::table &table, const std::string &origin, key_places &places)
{
    for (const auto &[name, value] : table) {
        const std::string section(name.str());
        if (const auto *entries = value.as_table()) {
            for (const auto &[entry, entry_value] : *entries) {
                const std::string entry_name(entry.str());
                const std::string where = place(origin, entry.source());
                if (section == "signals") {
                    read_signal(rig, entry_name, entry_value, where);
                } else if (section == "tolerances") {
                    set_tolerance(rig, entry_name, entry_value, where);
                } else {
                    const std::string path = section + "." + entry_name;
                    read_value(rig, path, split_tolerance(rig, path, entry_value, where), where);
                    places[path] = where;
                }
            }
            if (section == "signals" || section == "tolerances") {
                continue;
            }
            if (const auto nearest = nearest_section(section); nearest != section) {
                fail(place(origin, name.source()),
                     {section, "unknown section; the nearest known one is " + std::string(nearest)});
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

void apply_robot(rig &rig, const robot_preset &robot, key_places &places)
{
    for (const robot_preset::setting &setting : robot.settings) {
        if (!setting.text.empty()) {
            set_value(rig, setting.path, setting.text); /* was checked when the preset was read */
        }
        places[setting.path] = setting.where;
    }
}

/* `context` is added where the fault may lie in what the message does not name. */
void check(rig &rig, const std::string &origin, const key_places &places, const std::string &context)
{
    if (auto error = complete_and_check(rig)) {
        const auto found = places.find(error->key);
        error->message += context;
        fail(found == places.end() ? origin + " (default value)" : found->second, *error);
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

bool is_overridden(std::string_view path, const std::vector<std::string> &overrides)
{
    return std::any_of(overrides.begin(), overrides.end(),
                       [&](const std::string &override) { return override.substr(0, override.find('=')) == path; });
}

rig parse_rig(const std::string &text, const std::string &origin, const std::vector<std::string> &overrides,
              const robot_preset *robot)
{
    rig rig;
    key_places places;
    read_table(rig, parse_toml(text, origin), origin, places);
    if (robot != nullptr) {
        apply_robot(rig, *robot, places);
    }
    apply_overrides(rig, overrides, places);
    if (robot == nullptr) {
        check(rig, origin, places, "");
        return rig;
    }
    if (robot->dead_time_periods && !is_overridden("robot.dead_time_ms", overrides)) {
        rig.robot.dead_time_ms = *robot->dead_time_periods * 1e3 / rig.firmware.loop.rate_Hz;
    }
    const std::string context = "; with robot preset " + robot->name;
    check(rig, origin, places, context);
    if (const auto band = dead_time_band(*robot, overrides)) {
        berth::rig lower = rig;
        lower.robot.dead_time_ms = band->from;
        check(lower, origin, places, context + ", at the lower end of its range");
    }
    return rig;
}

rig load_rig(const std::string &name_or_path, const std::vector<std::string> &overrides, const robot_preset *robot)
{
    for (const auto &shipped : shipped_rigs()) {
        if (name_or_path == shipped.name) {
            return parse_rig(shipped.text, name_or_path + ".toml", overrides, robot);
        }
    }
    if (!looks_like_path(name_or_path) && !std::ifstream(name_or_path)) {
        throw input_error(name_or_path + ": no shipped rig has this name (" + names_of_shipped_rigs() +
                          ") and there is no such file");
    }
    rig rig = parse_rig(read_file(name_or_path), name_or_path, overrides, robot);
    if (rig.name.empty()) {
        rig.name = stem_of(name_or_path);
        if (!is_file_name(rig.name)) {
            throw input_error(name_or_path +
                              ": its name cannot name the log; give the rig another with name = \"...\"");
        }
    }
    return rig;
}

/* What is known about the values, and where records keep the signals. */
static void print_knowledge(const rig &rig, std::ostringstream &text)
{
    const auto number = [](double value) {
        char digits[32];
        const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
        const std::string result(digits, end);
        return result.find_first_not_of("-0123456789") == std::string::npos ? result + ".0" : result;
    };
    text << (rig.tolerances.empty() ? "" : "\n[tolerances]\n");
    for (const tolerance &known : rig.tolerances) {
        text << quoted(known.key) << " = " << number(known.share) << "\n";
    }
    text << (rig.signals.empty() ? "" : "\n[signals]\n");
    for (const signal_source &source : rig.signals) {
        text << source.signal << " = { column = " << quoted(source.column) << ", scale = " << number(source.scale)
             << ", offset = " << number(source.offset) << " }\n";
    }
}

std::string print_rig(const rig &rig)
{
    std::ostringstream text;
    text << "name = " << quoted(rig.name) << "\n";
    text << "description = " << quoted(rig.description) << "\n";
    std::string section;
    for (const rig_key &key : rig_keys()) {
        if (key.own_member == nullptr && rig.effect_values[key.effect_value] == 0.0) {
            continue; /* an effect that is not there */
        }
        const std::size_t dot = key.path.find('.');
        if (key.path.substr(0, dot) != section) {
            section = key.path.substr(0, dot);
            text << "\n[" << section << "]\n";
        }
        std::string line = std::string(key.path.substr(dot + 1)) + " = " + value_text(rig, key);
        line.resize(std::max<std::size_t>(line.size(), 50), ' ');
        text << line << " # " << key.meaning << "\n";
    }
    print_knowledge(rig, text);
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
