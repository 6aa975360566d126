#include "keys.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <type_traits>

namespace berth
{

namespace
{

enum class range { any, positive, not_negative, fraction, positive_or_inf, not_negative_or_inf };

template <typename T>
constexpr key_type type_of()
{
    if constexpr (std::is_same_v<T, double>) {
        return key_type::number;
    } else if constexpr (std::is_same_v<T, std::int64_t>) {
        return key_type::integer;
    } else if constexpr (std::is_same_v<T, bool>) {
        return key_type::boolean;
    } else if constexpr (std::is_same_v<T, std::string>) {
        return key_type::text;
    } else {
        return key_type::choice;
    }
}

template <typename T>
rig_key make_key(std::string_view path, void *(*member)(rig &), range range, std::string_view meaning,
                 std::vector<std::string_view> choices = {})
{
    rig_key key{path,  type_of<T>(), member, std::is_same_v<T, bool>, -unlimited, unlimited, true,
                false, {},           meaning};
    key.choices = std::move(choices);
    key.low = range == range::any ? -unlimited : 0.0;
    key.low_is_allowed = range != range::positive && range != range::positive_or_inf;
    key.high = range == range::fraction ? 1.0 : unlimited;
    key.infinity_is_allowed = range == range::positive_or_inf || range == range::not_negative_or_inf;
    return key;
}

/* A firmware flag is an int32_t without choices. */
rig_key make_flag(std::string_view path, void *(*member)(rig &), std::string_view meaning)
{
    rig_key key = make_key<bool>(path, member, range::any, meaning);
    key.is_bool = false;
    return key;
}

#define KEY(path, member, ...)                                                                                      \
    make_key<decltype(rig::member)>(                                                                                \
        path, [](rig &of) -> void * { return &of.member; }, __VA_ARGS__)
#define FLAG(path, member, meaning)                                                                                 \
    make_flag(                                                                                                      \
        path, [](rig &of) -> void * { return &of.member; }, meaning)

std::vector<rig_key> make_keys()
{
    using r = range;
    return {
        KEY("run.duration_s", run.duration_s, r::positive, "length of the run"),
        KEY("run.release_s", run.release_s, r::not_negative, "the operator requests to run from here on"),
        KEY("run.seed", run.seed, r::not_negative, "of every random draw"),
        KEY("run.emergency_stop_s", run.emergency_stop_s, r::not_negative_or_inf,
            "emergency stop is pressed; inf: never"),
        KEY("run.enable_off_s", run.enable_off_s, r::not_negative_or_inf, "enable is taken away; inf: never"),

        KEY("loop.rate_Hz", firmware.loop.rate_Hz, r::positive, "ticks a second; must divide 1e9"),
        KEY("loop.missed_ticks_budget", firmware.loop.missed_ticks_budget, r::not_negative,
            "missed ticks before the supervisor faults"),

        KEY("manipulator.mass_kg", firmware.manipulator.mass_kg, r::positive, "M"),
        KEY("manipulator.damping_N_s_per_m", firmware.manipulator.damping_N_s_per_m, r::not_negative, "D"),
        KEY("manipulator.stiffness_N_per_m", firmware.manipulator.stiffness_N_per_m, r::not_negative, "K"),
        KEY("manipulator.initial_position_m", firmware.manipulator.initial_position_m, r::any,
            "where the robot holds it until the release"),
        KEY("manipulator.initial_velocity_m_per_s", firmware.manipulator.initial_velocity_m_per_s, r::any,
            "at the release"),
        KEY("manipulator.integrator", firmware.manipulator.integrator, r::any, "of the manipulator step",
            {"exact", "semi_implicit_euler", "rk4"}),
        KEY("manipulator.substeps", firmware.manipulator.substeps, r::positive, "integrator steps per tick"),

        KEY("operator.interface", firmware.operator_command.interface, r::any,
            "commands a motion (x_op, v_op) or a force on the manipulator", {"motion", "force"}),
        KEY("operator.position_limit_m", firmware.operator_command.position_limit_m, r::positive,
            "larger commands are rejected"),
        KEY("operator.velocity_limit_m_per_s", firmware.operator_command.velocity_limit_m_per_s, r::positive,
            "larger commands are rejected"),
        KEY("operator.force_limit_N", firmware.operator_command.force_limit_N, r::positive,
            "larger commands are rejected"),
        KEY("operator.stale_after_ms", firmware.operator_command.stale_after_ms, r::positive,
            "age at which the loop holds"),

        KEY("profile.kind", profile.kind, r::any, "what the operator commands after the release",
            {"rest", "step", "ramp", "minimum_jerk", "chirp", "multisine", "file"}),
        KEY("profile.offset_m", profile.offset_m, r::any, "position about which the profile moves"),
        KEY("profile.amplitude_m", profile.amplitude_m, r::any, "for operator.interface = \"motion\""),
        KEY("profile.amplitude_N", profile.amplitude_N, r::any, "for operator.interface = \"force\""),
        KEY("profile.start_s", profile.start_s, r::not_negative, "after the release"),
        KEY("profile.duration_s", profile.duration_s, r::positive, "of ramp, move, chirp; period of the multisine"),
        KEY("profile.frequency_start_Hz", profile.frequency_start_Hz, r::positive, "of chirp and multisine"),
        KEY("profile.frequency_end_Hz", profile.frequency_end_Hz, r::positive, "of chirp and multisine"),
        KEY("profile.file", profile.file, r::any, "CSV (also .gz) with a header and a column t_s"),
        KEY("profile.column", profile.column, r::any,
            "of the file; may be left empty if there is only one beside t_s"),
        KEY("profile.scale", profile.scale, r::any, "file value to m or N"),

        KEY("sensor_channel.force_limit_N", firmware.sensor_channel.force_limit_N, r::positive,
            "larger measured forces are a fault"),
        KEY("sensor_channel.stale_after_ms", firmware.sensor_channel.stale_after_ms, r::positive,
            "age at which the loop holds"),
        KEY("robot_channel.stale_after_ms", firmware.robot_channel.stale_after_ms, r::positive,
            "age of feedback that is a fault"),
        KEY("robot_channel.start_tolerance_m", firmware.robot_channel.start_tolerance_m, r::positive,
            "robot to first setpoint"),
        KEY("limits.position_min_m", firmware.limits.position_min_m, r::any, "of setpoints on the wire"),
        KEY("limits.position_max_m", firmware.limits.position_max_m, r::any, "of setpoints on the wire"),
        KEY("limits.velocity_m_per_s", firmware.limits.velocity_m_per_s, r::positive, "of setpoints on the wire"),
        KEY("limits.acceleration_m_per_s2", firmware.limits.acceleration_m_per_s2, r::positive,
            "of setpoints on the wire"),
        FLAG("inverse_filter.enabled", firmware.inverse_filter.enabled,
             "takes away the amplitude error of robot.transfer_*"),
        KEY("inverse_filter.bandwidth_Hz", firmware.inverse_filter.bandwidth_Hz, r::positive,
            "of the filter's own poles"),

        KEY("robot.dead_time_ms", robot.dead_time_ms, r::not_negative,
            "command to motion, time on the bus included"),
        KEY("robot.interpolation", robot.interpolation, r::any, "between setpoints", {"linear", "hold"}),
        KEY("robot.transfer_frequency_Hz", robot.transfer_frequency_Hz, r::positive_or_inf,
            "of the second-order transfer behaviour; inf: none"),
        KEY("robot.transfer_damping_ratio", robot.transfer_damping_ratio, r::not_negative, "of the same"),
        KEY("robot.velocity_limit_m_per_s", robot.velocity_limit_m_per_s, r::positive_or_inf, "inf: none"),
        KEY("robot.acceleration_limit_m_per_s2", robot.acceleration_limit_m_per_s2, r::positive_or_inf, "inf: none"),
        KEY("robot.clock", robot.clock, r::any, "takes setpoints when they come, or by a clock of its own",
            {"locked", "free"}),
        KEY("robot.clock_phase_ms", robot.clock_phase_ms, r::not_negative, "of a free clock"),
        KEY("robot.clock_drift_ppm", robot.clock_drift_ppm, r::any, "of a free clock; positive: slow"),
        KEY("robot.jitter_ms", robot.jitter_ms, r::not_negative, "largest shift of a setpoint's instant"),

        KEY("sensor.stiffness_N_per_m", sensor.stiffness_N_per_m, r::positive, "k_S"),
        KEY("sensor.damping_ratio", sensor.damping_ratio, r::not_negative, "zeta_S; d_S = 2 zeta_S sqrt(k_S m)"),
        KEY("sensor.low_pass_order", sensor.low_pass_order, r::not_negative, "0, 1 or 2"),
        KEY("sensor.low_pass_frequency_Hz", sensor.low_pass_frequency_Hz, r::positive, "f_L"),
        KEY("sensor.low_pass_damping_ratio", sensor.low_pass_damping_ratio, r::positive, "zeta_L, order 2"),
        KEY("sensor.delay_ms", sensor.delay_ms, r::not_negative, "sample to arrival, time on the bus included"),
        KEY("sensor.sample_phase_ms", sensor.sample_phase_ms, r::not_negative, "sample after the tick"),
        KEY("sensor.bias_N", sensor.bias_N, r::any, "added to every sample"),
        KEY("sensor.noise_N", sensor.noise_N, r::not_negative, "standard deviation, one value a sample"),
        KEY("sensor.resolution_N", sensor.resolution_N, r::not_negative, "0: that of the frame"),
        KEY("sensor.saturation_N", sensor.saturation_N, r::positive_or_inf, "inf: that of the frame"),
        KEY("sensor.loss_probability", sensor.loss_probability, r::fraction, "a sample is never sent"),
        KEY("sensor.stale_probability", sensor.stale_probability, r::fraction, "the last frame is sent again"),

        KEY("object.kind", object.kind, r::any, "gripped object, or a tool that pushes on elastic material",
            {"gripped", "contact"}),
        KEY("object.mass_kg", object.mass_kg, r::positive, "m; contact: of the tool"),
        KEY("object.stiffness_N_per_m", object.stiffness_N_per_m, r::not_negative, "k"),
        KEY("object.damping_N_s_per_m", object.damping_N_s_per_m, r::not_negative, "d"),
        KEY("object.surface_position_m", object.surface_position_m, r::any,
            "contact: material beyond this position"),

        KEY("bus.bit_rate_bit_per_s", bus.bit_rate_bit_per_s, r::positive, "of both buses"),
        KEY("bus.ideal", bus.ideal, r::any, "frames take no time"),
        KEY("bus.loss_probability", bus.loss_probability, r::fraction, "a frame is lost"),
        KEY("bus.burst_probability", bus.burst_probability, r::fraction, "a burst of losses starts"),
        KEY("bus.burst_length_frames", bus.burst_length_frames, r::positive, "mean length of a burst"),
        KEY("bus.error_probability", bus.error_probability, r::fraction, "a frame is destroyed and sent again"),

        KEY("solver.kind", solver.kind, r::any, "of the simulated rig", {"fast", "cvode"}),
        KEY("solver.relative_tolerance", solver.relative_tolerance, r::positive, "cvode"),
        KEY("solver.absolute_tolerance_m", solver.absolute_tolerance_m, r::positive,
            "cvode; of the object's position, other states in proportion"),
        KEY("solver.contact_step_us", solver.contact_step_us, r::positive, "fast solver, object.kind = \"contact\""),
    };
}

std::string_view bare_name(std::string_view path)
{
    const std::size_t dot = path.rfind('.');
    return dot == std::string_view::npos ? path : path.substr(dot + 1);
}

/* Levenshtein distance. */
std::size_t edit_distance(std::string_view a, std::string_view b)
{
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); i++) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); j++) {
            const std::size_t above = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
            diagonal = above;
        }
    }
    return row[b.size()];
}

/* A key that only lacks its unit counts as very near. */
std::size_t distance(std::string_view wanted, std::string_view known)
{
    const bool lacks_unit =
        known.size() > wanted.size() && known.substr(0, wanted.size()) == wanted && known[wanted.size()] == '_';
    return lacks_unit ? 0 : edit_distance(wanted, known);
}

std::string range_text(const rig_key &key)
{
    if (key.high == 1.0) {
        return "must be from 0 to 1";
    }
    return key.low_is_allowed ? "must be 0 or more" : "must be greater than 0";
}

bool in_range(const rig_key &key, double value)
{
    return value <= key.high && (key.low_is_allowed ? value >= key.low : value > key.low);
}

template <typename T>
bool parse(std::string_view text, T &value)
{
    if (!text.empty() && text.front() == '+') {
        text.remove_prefix(1);
    }
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() && !text.empty();
}

std::string without_underscores(std::string_view text)
{
    std::string result(text);
    result.erase(std::remove(result.begin(), result.end(), '_'), result.end());
    return result;
}

std::optional<rig_error> set_choice(rig &rig, const rig_key &key, std::string_view word)
{
    const auto found = std::find(key.choices.begin(), key.choices.end(), word);
    if (found == key.choices.end()) {
        std::string message = "must be one of";
        for (const auto choice : key.choices) {
            message += (choice == key.choices.front() ? " \"" : ", \"") + std::string(choice) + "\"";
        }
        return rig_error{std::string(key.path), message + " (is \"" + std::string(word) + "\")"};
    }
    *static_cast<std::int32_t *>(key.member(rig)) = static_cast<std::int32_t>(found - key.choices.begin());
    return {};
}

std::optional<rig_error> set_boolean(rig &rig, const rig_key &key, std::string_view text)
{
    if (text != "true" && text != "false") {
        return rig_error{std::string(key.path), "must be true or false (is " + std::string(text) + ")"};
    }
    if (key.is_bool) {
        *static_cast<bool *>(key.member(rig)) = text == "true";
    } else {
        *static_cast<std::int32_t *>(key.member(rig)) = text == "true";
    }
    return {};
}

std::optional<rig_error> set_number(rig &rig, const rig_key &key, std::string_view text)
{
    double value = 0.0;
    if (!parse(without_underscores(text), value)) {
        return rig_error{std::string(key.path), "must be a number (is " + std::string(text) + ")"};
    }
    if (std::isnan(value) || (std::isinf(value) && !key.infinity_is_allowed)) {
        return rig_error{std::string(key.path), "must be a finite number (is " + std::string(text) + ")"};
    }
    if (!in_range(key, value)) {
        return rig_error{std::string(key.path), range_text(key) + " (is " + std::string(text) + ")"};
    }
    if (key.type == key_type::number) {
        *static_cast<double *>(key.member(rig)) = value;
        return {};
    }
    if (value != std::floor(value) || std::abs(value) > 9e15) {
        return rig_error{std::string(key.path), "must be a whole number (is " + std::string(text) + ")"};
    }
    *static_cast<std::int64_t *>(key.member(rig)) = static_cast<std::int64_t>(value);
    return {};
}

} // namespace

const std::vector<rig_key> &rig_keys()
{
    static const std::vector<rig_key> keys = make_keys();
    return keys;
}

const rig_key *find_key(std::string_view path)
{
    const auto &keys = rig_keys();
    const auto found = std::find_if(keys.begin(), keys.end(), [&](const rig_key &key) { return key.path == path; });
    return found == keys.end() ? nullptr : &*found;
}

std::string_view nearest_key(std::string_view path)
{
    const bool has_section = path.find('.') != std::string_view::npos;
    const auto &keys = rig_keys();
    const auto to_wanted = [&](const rig_key &key) {
        return distance(path, has_section ? key.path : bare_name(key.path));
    };
    return std::min_element(keys.begin(), keys.end(),
                            [&](const rig_key &a, const rig_key &b) { return to_wanted(a) < to_wanted(b); })
        ->path;
}

std::optional<rig_error> set_value(rig &rig, std::string_view path, std::string_view text)
{
    const rig_key *key = find_key(path);
    if (key == nullptr) {
        return rig_error{std::string(path),
                         "unknown key; the nearest known one is " + std::string(nearest_key(path))};
    }
    if (text.size() >= 2 && text.front() == '"' && text.back() == '"') {
        text = text.substr(1, text.size() - 2);
    }
    switch (key->type) {
    case key_type::text:
        if (const auto error = text_error(text)) {
            return rig_error{std::string(path), *error};
        }
        *static_cast<std::string *>(key->member(rig)) = std::string(text);
        return {};
    case key_type::choice:
        return set_choice(rig, *key, text);
    case key_type::boolean:
        return set_boolean(rig, *key, text);
    default:
        return set_number(rig, *key, text);
    }
}

std::string quoted(std::string_view text)
{
    std::string result = "\"";
    for (const char c : text) {
        if (is_control(c)) {
            char code[8];
            std::snprintf(code, sizeof code, "\\u%04X", static_cast<unsigned>(c));
            result += code;
            continue;
        }
        if (c == '"' || c == '\\') {
            result += '\\';
        }
        result += c;
    }
    return result + '"';
}

bool is_control(char c)
{
    return (c >= 0 && c < ' ') || c == 0x7f;
}

std::optional<std::string> text_error(std::string_view text)
{
    if (text.size() <= text_bytes_max) {
        return {};
    }
    return "must not be longer than " + std::to_string(text_bytes_max) + " bytes (is " +
           std::to_string(text.size()) + ")";
}

std::string value_text(const rig &rig, const rig_key &key)
{
    void *member = key.member(const_cast<berth::rig &>(rig));
    switch (key.type) {
    case key_type::text:
        return quoted(*static_cast<std::string *>(member));
    case key_type::choice:
        return '"' + std::string(key.choices[static_cast<std::size_t>(*static_cast<std::int32_t *>(member))]) + '"';
    case key_type::boolean:
        return (key.is_bool ? *static_cast<bool *>(member) : *static_cast<std::int32_t *>(member) != 0) ? "true"
                                                                                                        : "false";
    case key_type::integer:
        return std::to_string(*static_cast<std::int64_t *>(member));
    case key_type::number:
        break;
    }
    char text[32];
    const auto [end, error] = std::to_chars(text, text + sizeof text, *static_cast<double *>(member));
    std::string result(text, end);
    const bool is_whole = result.find_first_not_of("-0123456789") == std::string::npos;
    return is_whole ? result + ".0" : result;
}

} // namespace berth
