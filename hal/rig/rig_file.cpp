#include "rig_file.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "arm_table.h"
#include "axes.h"
#include "beam.h"
#include "given_file.h"
#include "keys.h"
#include "knowledge.h"
#include "names.h"
#include "orders.h"
#include "other_files.h"
#include "robot_file.h"
#include "toml_file.h"
#include "wrench.h"

namespace berth
{

namespace
{

const std::string arm_section = "manipulator.arm";

void read_top_level(rig &rig, const std::string &name, const toml::node &value, const std::string &where)
{
    std::string *member = name == "name" ? &rig.name : name == "description" ? &rig.description : nullptr;
    if (member == nullptr) {
        fail(where, {name, "unknown key; keys stand in a section, the nearest known one is " +
                               std::string(nearest_key(name))});
    }
    *member = member == &rig.name ? read_file_name(name, value, where) : read_text(name, value, where);
}

void put_arm(rig &rig, const arm_description &arm)
{
    rig.firmware.arm = arm.config;
    rig.arm_text = print_arm(arm, arm_section);
    rig.arm.clear();
}

void refuse_unknown_section(const std::string &section, const std::string &where)
{
    for (const char *const own : {"signals", "tolerances", "axis", "wrench", "orders"}) {
        if (section == own) {
            return;
        }
    }
    if (const auto nearest = nearest_section(section); nearest != section) {
        fail(where, {section, "unknown section; the nearest known one is [" + std::string(nearest) + "]"});
    }
}

void read_table(rig &rig, const toml::table &table, const std::string &origin, key_places &places)
{
    for (const auto &[name, value] : table) {
        const std::string section(name.str());
        if (section == "base" || section == "assumed") {
            continue; /* about the file, no values of the rig */
        }
        if (value.is_table()) {
            refuse_unknown_section(section, place(origin, name.source()));
        }
        if (const auto *entries = value.as_table(); entries != nullptr && section == "wrench") {
            read_wrench(rig, *entries, origin);
            places["wrench"] = place(origin, name.source());
        } else if (entries != nullptr) {
            for (const auto &[entry, entry_value] : *entries) {
                const std::string entry_name(entry.str());
                const std::string where = place(origin, entry.source());
                if (section == "axis") {
                    read_axis(rig, entry_name, entry_value, origin);
                    places["axis." + entry_name] = where;
                } else if (section == "signals") {
                    read_signal(rig, entry_name, entry_value, where);
                } else if (section == "tolerances") {
                    set_tolerance(rig, entry_name, entry_value, where);
                } else if (entry_value.is_table() && section == "manipulator" && entry_name == "arm") {
                    put_arm(rig, read_arm(*entry_value.as_table(), origin));
                    places[arm_section] = where;
                } else {
                    std::string path = section;
                    path.append(".").append(entry_name);
                    read_value(rig, path, split_tolerance(rig, path, entry_value, where), where);
                    places[path] = where;
                }
            }
        } else if (section == "orders") {
            read_orders(rig, value, origin, places);
        } else {
            read_top_level(rig, section, value, place(origin, name.source()));
        }
    }
}

bool stands_in_own_section(std::string_view path)
{
    const std::string_view section = path.substr(0, path.find('.'));
    return section == "axis" || section == "wrench" || section == "orders";
}

void apply_overrides(rig &rig, const std::vector<std::string> &overrides, key_places &places)
{
    for (const std::string &override : overrides) {
        const std::size_t equals = override.find('=');
        if (equals == std::string::npos) {
            throw input_error("--set " + override + ": must look like section.key=value, as object.mass_kg=40");
        }
        const std::string path = override.substr(0, equals);
        const std::string where = "--set " + override;
        if (stands_in_own_section(path)) {
            fail(where, {path, "is set in the rig file alone; berth run RIG --print-config prints one to change"});
        }
        if (const auto error = set_value(rig, path, override.substr(equals + 1))) {
            fail(where, *error);
        }
        places[path] = where;
        set_given(rig, path, true);
    }
}

/* What would be passed over in silence. */
void check_object_keys(const rig &rig, const key_places &places)
{
    const bool is_beam = rig.object.kind == object_kind::beam;
    for (const auto &[path, where] : places) {
        if (is_beam && follows_from_beam(path)) {
            fail(where,
                 {path, "follows from the beam with object.kind = \"beam\": leave it out, and change "
                        "object.beam_mass_kg_per_m, object.beam_stiffness_N_m2 or object.beam_damping_ratio"});
        }
        if (!is_beam && belongs_to_beam(path)) {
            fail(where,
                 {path, "counts with object.kind = \"beam\" only: set that, or leave this out; one mode alone "
                        "is object.modes = 1"});
        }
    }
}

void apply_robot(rig &rig, const robot_preset &robot, key_places &places)
{
    for (const robot_preset::setting &setting : robot.settings) {
        if (setting.path == "robot.dead_time_ms") {
            follow_dead_time(rig);
        }
        if (!setting.text.empty()) {
            set_value(rig, setting.path, setting.text); /* was checked when the preset was read */
        }
        places[setting.path] = setting.where;
        set_given(rig, setting.path, true);
    }
}

/* A section that is read as a whole has one place, and so has each order. */
std::string place_of(const rig_error &error)
{
    if (error.order > 0) {
        return place_key_of_order(error.order);
    }
    const std::string &key = error.key;
    if (key.rfind("wrench.", 0) == 0) {
        return "wrench";
    }
    return key.rfind("axis.", 0) == 0 ? key.substr(0, key.find('.', 5)) : key;
}

/* `context` is added where the fault may lie in what the message does not name. */
void check(rig &rig, const std::string &origin, const key_places &places, const std::string &context)
{
    if (auto error = complete_and_check(rig)) {
        const auto found = places.find(place_of(*error));
        error->message += context;
        if (!rig.is_rate_given && error->message.find("period") != std::string::npos) {
            error->message += "; no loop.rate_Hz is given, 400 is the default";
        }
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

std::string read_rig_file(const std::string &path)
{
    std::string text = read_file(path, written_bytes_max);
    refuse_other_file(path, text);
    return text;
}

/* The text of the rig that a file builds on, and what to call it in messages. */
std::pair<std::string, std::string> base_text(const toml::node &base, const std::string &where)
{
    const std::string name = read_text("base", base, where);
    for (const auto &shipped : shipped_rigs()) {
        if (name == shipped.name) {
            return {shipped.text, name + ".toml"};
        }
    }
    if (is_folder(name) || !std::ifstream(name)) {
        fail(where,
             {"base", "must be a shipped rig (" + names_of_shipped_rigs() + ") or the path of a rig file (is " +
                          in_quotes(name) + ")" + did_you_mean(names_of_files(shipped_rigs()), name)});
    }
    return {read_rig_file(name), name};
}

/* `base = "ess"`: what the file leaves out is taken from another rig, which counts as stated. Its name, description
 * and orders are not taken along where the file has its own. */
void read_with_base(rig &rig, const toml::table &table, const std::string &origin, key_places &places)
{
    if (const toml::node *const base = table.get("base")) {
        const std::string where = place(origin, base->source());
        const auto [text, base_origin] = base_text(*base, where);
        const toml::table under = parse_toml(text, base_origin);
        if (under.contains("base")) {
            fail(where, {"base", "names a rig that has a base itself: name that one"});
        }
        read_table(rig, under, base_origin, places);
        rig.name.clear();
        rig.description.clear();
        if (table.contains("orders")) {
            rig.orders.clear();
        }
    }
    read_table(rig, table, origin, places);
    note_given(rig, places);
    if (const toml::node *const assumed = table.get("assumed")) {
        for (const std::string &name : read_assumed(*assumed, place(origin, assumed->source()))) {
            set_assumed(rig, name);
        }
    }
}

} // namespace

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
    read_with_base(rig, parse_toml(text, origin), origin, places);
    if (robot != nullptr) {
        apply_robot(rig, *robot, places);
    }
    apply_overrides(rig, overrides, places);
    check_object_keys(rig, places);
    rig.is_rate_given = places.count("loop.rate_Hz") > 0;
    if (!rig.arm.empty()) {
        put_arm(rig, load_arm(rig.arm));
    }
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
        show_dead_time(lower, band->from);
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
                          ") and there is no such file" +
                          did_you_mean(names_of_files(shipped_rigs()), name_or_path));
    }
    rig rig = parse_rig(read_rig_file(name_or_path), name_or_path, overrides, robot);
    if (rig.name.empty()) {
        rig.name = stem_of(name_or_path);
        if (!is_file_name(rig.name)) {
            throw input_error(name_or_path +
                              ": its name cannot name the log; give the rig another with name = \"...\"");
        }
    }
    return rig;
}

namespace
{

std::string print_with(const rig &rig, const std::string &head,
                       std::string (*mark)(const berth::rig &, const rig_key &))
{
    std::ostringstream text;
    text << "name = " << in_quotes(rig.name) << "\n";
    text << "description = " << in_quotes(rig.description) << "\n" << head;
    std::string section;
    for (const rig_key &key : rig_keys()) {
        if (key.own_member == nullptr && rig.effect_values[key.effect_value] == 0.0) {
            continue; /* an effect that is not there */
        }
        const bool is_beam = rig.object.kind == object_kind::beam;
        if (is_beam ? follows_from_beam(key.path) : belongs_to_beam(key.path)) {
            continue;
        }
        if (key.path == arm_section && !rig.arm_text.empty()) {
            continue; /* it follows whole */
        }
        const std::size_t dot = key.path.find('.');
        if (key.path.substr(0, dot) != section) {
            section = key.path.substr(0, dot);
            text << "\n[" << section << "]\n";
        }
        std::string line = std::string(key.path.substr(dot + 1)) + " = " + value_text(rig, key);
        line.resize(std::max<std::size_t>(line.size(), 50), ' ');
        text << line << " # " << mark(rig, key) << key.meaning << "\n";
    }
    print_knowledge(rig, text);
    print_axes(rig, text);
    print_orders(rig, text);
    if (!rig.arm_text.empty()) {
        text << "\n" << rig.arm_text;
    }
    return text.str();
}

} // namespace

std::string print_rig(const rig &rig)
{
    return print_with(rig, "", [](const berth::rig &, const rig_key &) { return std::string(); });
}

std::string print_config(const rig &rig)
{
    std::string head;
    for (const std::string &name : assumed_names(rig)) {
        head += (head.empty() ? "assumed = [" : ", ") + in_quotes(name);
    }
    return print_with(rig, head.empty() ? head : head + "]\n", [](const berth::rig &of, const rig_key &key) {
        return std::string(given_mark(of, key.path));
    });
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
