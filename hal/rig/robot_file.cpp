#include "robot_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>

#include "keys.h"
#include "names.h"
#include "toml_file.h"

namespace berth
{

namespace
{

/* What belongs to a robot, its interface and the loop that drives it; everything else is the rig's. */
constexpr std::array<std::string_view, 8> sections = {"loop",   "robot",          "robot_channel", "cia402",
                                                      "sensor", "sensor_channel", "bus",           "limits"};

std::string decimal(double value)
{
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    return {digits, end};
}

double read_positive(const std::string &path, const toml::node &value, const std::string &where)
{
    const auto number = value.is_number() ? value.value<double>() : std::nullopt;
    if (!number || !std::isfinite(*number) || !(*number > 0.0)) {
        fail(where, {path, "must be a finite number greater than 0 (is " + text_of(value) + ")"});
    }
    return *number;
}

class preset_reader
{
  public:
    explicit preset_reader(std::string origin) : origin_(std::move(origin)) {}

    robot_preset read(const toml::table &table)
    {
        for (const auto &[name, value] : table) {
            const std::string section(name.str());
            const std::string where = place(origin_, name.source());
            if (const auto *entries = value.as_table()) {
                check_section(section, where);
                for (const auto &[entry, entry_value] : *entries) {
                    read_entry(section + "." + std::string(entry.str()), entry_value,
                               place(origin_, entry.source()));
                }
            } else {
                read_top_level(section, value, where);
            }
        }
        if (preset_.source.empty()) {
            throw input_error(origin_ + ": source: is missing: say in a sentence who reports these values");
        }
        return std::move(preset_);
    }

  private:
    void read_top_level(const std::string &name, const toml::node &value, const std::string &where)
    {
        if (name == "name") {
            preset_.name = read_file_name(name, value, where);
        } else if (name == "description") {
            preset_.description = read_text(name, value, where);
        } else if (name == "source") {
            preset_.source = read_text(name, value, where);
        } else if (name == "assumed") {
            preset_.assumed = read_text(name, value, where);
        } else {
            fail(where, {name, "unknown key; outside of its sections a preset has name, description, source and "
                               "assumed"});
        }
    }

    static void check_section(const std::string &section, const std::string &where)
    {
        if (std::find(sections.begin(), sections.end(), section) != sections.end()) {
            return;
        }
        std::string known;
        for (const std::string_view each : sections) {
            known += (known.empty() ? "" : ", ") + std::string(each);
        }
        fail(where, {section, "is no section of a robot preset; it has " + known});
    }

    void read_entry(const std::string &path, const toml::node &value, const std::string &where)
    {
        if (path == "loop.period_ms") {
            preset_.period_ms = read_positive(path, value, where);
            const auto period_ns = std::max(1.0, std::round(1e6 * *preset_.period_ms));
            add(path, "loop.rate_Hz", decimal(1e9 / period_ns), where);
        } else if (path == "robot.dead_time_periods") {
            preset_.dead_time_periods = read_positive(path, value, where);
            add(path, "robot.dead_time_ms", "", where);
        } else if (path == "robot.dead_time_ms") {
            preset_.dead_time_ms = read_range(path, value, where);
            add(path, path, decimal(preset_.dead_time_ms->to), where);
        } else if (path == "robot.plus_drive_lag") {
            if (!value.is_boolean()) {
                fail(where, {path, "must be true or false (is " + text_of(value) + ")"});
            }
            preset_.plus_drive_lag = value.as_boolean()->get();
        } else {
            read_value(scratch_, path, value, where);
            add(path, path, value_text(scratch_, *find_key(path)), where);
            if (path == "loop.rate_Hz") {
                preset_.period_ms = 1e3 / scratch_.firmware.loop.rate_Hz;
            } else if (path == "sensor.delay_ms") {
                preset_.force_delay_ms = scratch_.sensor.delay_ms;
            }
        }
    }

    /* One value, or a range [from, to]. */
    range_ms read_range(const std::string &path, const toml::node &value, const std::string &where)
    {
        const toml::array *const ends = value.as_array();
        if (ends == nullptr) {
            read_value(scratch_, path, value, where);
            return {scratch_.robot.dead_time_ms, scratch_.robot.dead_time_ms};
        }
        if (ends->size() != 2) {
            fail(where, {path, "must be a number or a range of two, such as [40.0, 80.0]"});
        }
        read_value(scratch_, path, (*ends)[0], where);
        const double from = scratch_.robot.dead_time_ms;
        read_value(scratch_, path, (*ends)[1], where);
        const double to = scratch_.robot.dead_time_ms;
        if (from > to) {
            const std::string low = value_text_of(to);
            const std::string high = value_text_of(from);
            fail(where, {path, "the range from " + high + " to " + low + " is reversed; did you mean [" + low +
                                   ", " + high + "]?"});
        }
        return {from, to};
    }

    static std::string value_text_of(double dead_time_ms)
    {
        rig rig;
        rig.robot.dead_time_ms = dead_time_ms;
        return value_text(rig, *find_key("robot.dead_time_ms"));
    }

    void add(const std::string &stated, const std::string &path, const std::string &text, const std::string &where)
    {
        for (const robot_preset::setting &other : preset_.settings) {
            if (other.path == path) {
                fail(where, {stated, "says the same as another key of the preset; leave one out"});
            }
        }
        preset_.settings.push_back({path, text, where});
    }

    std::string origin_;
    robot_preset preset_;
    rig scratch_; /* values are checked by setting them */
};

} // namespace

robot_preset parse_robot(const std::string &text, const std::string &origin)
{
    robot_preset preset = preset_reader(origin).read(parse_toml(text, origin));
    preset.text = text;
    return preset;
}

robot_preset load_robot(const std::string &name_or_path)
{
    for (const auto &shipped : shipped_robots()) {
        if (name_or_path == shipped.name) {
            return parse_robot(shipped.text, name_or_path + ".toml");
        }
    }
    if (!looks_like_path(name_or_path) && !std::ifstream(name_or_path)) {
        const std::string near = near_name(names_of_files(shipped_robots()), name_or_path);
        throw input_error(name_or_path + ": no robot preset has this name, and there is no such file; " +
                          (near.empty() ? "`berth robots` lists them"
                                        : "the nearest is " + near + " (`berth robots` lists them)"));
    }
    robot_preset preset = parse_robot(read_file(name_or_path, written_bytes_max), name_or_path);
    if (preset.name.empty()) {
        preset.name = stem_of(name_or_path);
        if (!is_file_name(preset.name)) {
            throw input_error(name_or_path +
                              ": its name cannot name files; give the preset another with name = \"...\"");
        }
    }
    return preset;
}

void show_dead_time(rig &rig, double dead_time_ms)
{
    rig.robot.dead_time_ms = dead_time_ms;
    for (side_axis_rig &axis : rig.side_axes) {
        axis.dead_time_ms = dead_time_ms;
    }
}

std::optional<range_ms> dead_time_band(const robot_preset &robot, const std::vector<std::string> &overrides)
{
    const bool is_range = robot.dead_time_ms && robot.dead_time_ms->from < robot.dead_time_ms->to;
    return is_range && !is_overridden("robot.dead_time_ms", overrides) ? robot.dead_time_ms : std::nullopt;
}

} // namespace berth
