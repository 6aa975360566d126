#include "map_request.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "../../firmware/pi.h"
#include "../../hal/rig/beam.h"
#include "../../hal/rig/names.h"
#include "../compensation/measured_map.h"
#include "../prediction.h"
#include "../stability/compensation_states.h"
#include "../stability/loop_timeline.h"
#include "amplitude.h"

namespace berth
{

namespace
{

constexpr int axis_count_max = 1000000;
constexpr std::size_t points_max = 2000000000;

template <typename T>
T parse(const std::string &option, const std::string &text, const char *what)
{
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) {
        throw input_error(option + ": \"" + text + "\" is not " + what);
    }
    return value;
}

std::vector<std::string> split(const std::string &text, char separator)
{
    std::vector<std::string> parts{""};
    for (const char c : text) {
        if (c == separator) {
            parts.emplace_back();
        } else {
            parts.back() += c;
        }
    }
    return parts;
}

void set_range(map_axis &axis, const std::string &option, const std::string &from, const std::string &to)
{
    axis.from = parse<double>(option, from, "a number");
    axis.to = parse<double>(option, to, "a number");
    if (!std::isfinite(axis.from) || !std::isfinite(axis.to)) {
        throw input_error(option + ": the ends of the range must be finite numbers (are " + from + " and " + to +
                          ")");
    }
    if (axis.from == axis.to) {
        throw input_error(option + ": the range from " + from + " to " + to + " has no width");
    }
    if (axis.from > axis.to) {
        throw input_error(option + ": the range from " + from + " to " + to + " is empty; did you mean " + to + ":" +
                          from + "?");
    }
}

void set_count(map_axis &axis, const std::string &option, const std::string &text)
{
    const auto count = parse<std::int64_t>(option, text, "a whole number of points");
    if (count < 2 || count > axis_count_max) {
        throw input_error(option + ": an axis has 2 to " + std::to_string(axis_count_max) + " points (are " + text +
                          ")");
    }
    axis.count = static_cast<int>(count);
}

/* The key's own check of both ends is one of all values between them. */
void check_key(const rig &base, const std::string &option, const map_axis &axis)
{
    const rig_key *const key = find_key(axis.name);
    if (key == nullptr) {
        throw input_error(option + ": " + axis.name + ": " + unknown_key_words(axis.name));
    }
    if (axis.name.rfind("profile.", 0) == 0 || axis.name.rfind("run.", 0) == 0) {
        throw input_error(
            option + ": " + axis.name +
            " is a command to the rig, and no property of it; the amplitude at which effects are taken "
            "is --amplitude");
    }
    if (base.firmware.arm.kind != ARM_NONE &&
        (axis.name == "manipulator.mass_kg" || axis.name == "manipulator.damping_N_s_per_m" ||
         axis.name == "manipulator.stiffness_N_per_m")) {
        throw input_error(option + ": " + axis.name +
                          " is of a manipulator of one degree of freedom; here the arm in "
                          "its place decides (manipulator.arm)");
    }
    if (key->type != key_type::number && key->type != key_type::integer) {
        throw input_error(option + ": " + axis.name + " is not a number, so there is no range of it");
    }
    rig trial = base;
    for (int i = 0; i < axis.count; i += key->type == key_type::integer ? 1 : axis.count - 1) {
        char text[32];
        const auto end = std::to_chars(text, text + sizeof text, axis.value(i)).ptr;
        if (const auto error = set_value(trial, axis.name, std::string(text, end))) {
            throw input_error(option + ": " + error->key + " " + error->message);
        }
    }
}

map_axis key_axis(const rig &base, const std::string &option, const std::string &text)
{
    const std::size_t equals = text.find('=');
    const std::vector<std::string> range =
        equals == std::string::npos ? std::vector<std::string>{} : split(text.substr(equals + 1), ':');
    if (range.size() != 3) {
        throw input_error(option + ": must read KEY=FROM:TO:COUNT, such as object.mass_kg=10:300:200 (is \"" + text +
                          "\")");
    }
    map_axis axis;
    axis.name = text.substr(0, equals);
    set_range(axis, option, range[0], range[1]);
    set_count(axis, option, range[2]);
    check_key(base, option, axis);
    return axis;
}

void set_range_if_given(map_axis &axis, const std::string &option, const std::string &text)
{
    if (text.empty()) {
        return;
    }
    const std::vector<std::string> range = split(text, ':');
    if (range.size() != 2) {
        throw input_error(option + ": must read FROM:TO (is \"" + text + "\")");
    }
    set_range(axis, option, range[0], range[1]);
}

/* From an object without stiffness, less a fifth, to a fifth beyond the wall; or from sixteen times the least total
 * mass to a little beyond an object without mass. */
void set_default_ranges(map_request &request)
{
    const manipulator_config &arm = request.rig.firmware.manipulator;
    const object_rig &object = request.rig.object;
    const double own = map_point_of(request.rig).frequency_ratio;
    if (request.kind == map_kind::elasticity) {
        const double arm_Hz = std::sqrt(arm.stiffness_N_per_m / arm.mass_kg) / (2.0 * pi);
        request.x.from = 0.8 * std::sqrt(arm.mass_kg / (arm.mass_kg + object.mass_kg));
        request.x.to = 1.2 * std::max(wall_Hz / arm_Hz, own);
    } else {
        const double without_mass = std::sqrt(1.0 + object.stiffness_N_per_m / arm.stiffness_N_per_m);
        request.x.from = std::min(0.25 * without_mass, 0.8 * own);
        request.x.to = 1.05 * without_mass;
    }
    request.y.from = 0.0;
    request.y.to = std::max(0.3, 1.2 * map_point_of(request.rig).damping_ratio);
}

map_request coupled_request(const map_arguments &arguments, rig &&base)
{
    map_request request;
    request.rig = std::move(base);
    if (arguments.vary != "elasticity" && arguments.vary != "mass") {
        throw input_error("--vary: must be elasticity or mass (is \"" + arguments.vary + "\")" +
                          did_you_mean({"elasticity", "mass"}, arguments.vary));
    }
    request.kind = arguments.vary == "mass" ? map_kind::mass : map_kind::elasticity;
    if (!(request.rig.firmware.manipulator.stiffness_N_per_m > 0.0)) {
        throw input_error("--vary: manipulator.stiffness_N_per_m is 0, so there is no frequency ratio; use --x and "
                          "--y with keys of the rig");
    }
    request.x.name = frequency_ratio_axis;
    request.y.name = damping_ratio_axis;
    set_default_ranges(request);
    set_range_if_given(request.x, "--x-range", arguments.x_range);
    set_range_if_given(request.y, "--y-range", arguments.y_range);
    if (!(request.x.from > 0.0)) {
        throw input_error("--x-range: a frequency ratio must be greater than 0");
    }
    if (request.y.from < 0.0) {
        throw input_error("--y-range: a damping ratio must be 0 or more");
    }
    const std::vector<std::string> counts = split(arguments.grid, 'x');
    if (counts.size() != 2) {
        throw input_error("--grid: must read NXxNY, such as 200x200 (is \"" + arguments.grid + "\")");
    }
    set_count(request.x, "--grid", counts[0]);
    set_count(request.y, "--grid", counts[1]);
    return request;
}

/* Of which the map speaks: that of every linear method. */
void check_has_modes(rig base, double amplitude_m)
{
    base.firmware.identification.enabled = 0;
    base.firmware.adaptive_inverse.enabled = 0;
    base.firmware.passivity.action = PASSIVITY_OFF;
    spectral_radius_of(linear_at(without_variation(base), amplitude_m)); /* refuses rigs without one */
}

told_model told_by(const map_arguments &arguments, const rig &base)
{
    if (arguments.model != "point" && !compensation_is_on(&base.firmware)) {
        throw input_error("--model: there is no compensation that could be told anything; say --with prediction, or "
                          "switch one on");
    }
    return arguments.model == "rig"          ? told_model::of_the_rig
           : arguments.model == "tolerances" ? told_model::with_tolerances
                                             : told_model::of_the_point;
}

/* What would be passed over in silence. */
void check_object_axes(const map_request &request, const rig &base)
{
    const bool is_beam = base.object.kind == object_kind::beam;
    for (const auto *const axis : {&request.x, &request.y}) {
        const map_axis &other = axis == &request.x ? request.y : request.x;
        if (belongs_to_beam(axis->name) && !is_beam) {
            throw input_error("map: " + axis->name + " counts with object.kind = \"beam\" only");
        }
        if (belongs_to_beam(axis->name) && follows_from_beam(other.name)) {
            throw input_error("map: " + other.name + " follows from " + axis->name + ": vary one of them");
        }
    }
}

} // namespace

bool is_measured(const map_arguments &arguments, const rig &rig)
{
    return arguments.time_domain || !compensation_is_linear(rig);
}

std::vector<rig> corners_of(const map_request &request)
{
    std::vector<rig> corners{request.rig};
    map_point_setter setter(request);
    for (const double x : {request.x.from, request.x.to}) {
        for (const double y : {request.y.from, request.y.to}) {
            if (setter.set(x, y) == point_state::possible) {
                corners.push_back(setter.rig());
            }
        }
    }
    return corners;
}

map_request make_map_request(const map_arguments &arguments, rig base)
{
    const bool has_keys = !arguments.x.empty() || !arguments.y.empty();
    if (arguments.vary.empty() == !has_keys) {
        throw input_error("map: give either --vary elasticity, --vary mass, or both --x and --y");
    }
    const bool runs = is_measured(arguments, base);
    const double amplitude_m = chosen_amplitude_m(arguments, base);
    check_has_modes(base, amplitude_m);
    map_request request;
    const told_model told = told_by(arguments, base);
    if (runs) {
        base = released_rig(base, arguments.amplitude_m.value_or(0.0));
    } else if (amplitude_m == 0.0) {
        base = in_contact(base);
    }
    if (!has_keys) {
        request = coupled_request(arguments, std::move(base));
    } else {
        if (arguments.x.empty() || arguments.y.empty()) {
            throw input_error(std::string("map: ") + (arguments.x.empty() ? "--x" : "--y") + " is missing");
        }
        request.kind = map_kind::keys;
        request.x = key_axis(base, "--x", arguments.x);
        request.y = key_axis(base, "--y", arguments.y);
        if (request.x.name == request.y.name) {
            throw input_error("--y: " + request.y.name + " is the x axis already");
        }
        check_object_axes(request, base);
        request.rig = std::move(base);
    }
    request.told = told;
    request.amplitude_m = 0.0;
    for (const rig &corner : corners_of(request)) {
        if (!runs) {
            request.amplitude_m = std::max(request.amplitude_m, chosen_amplitude_m(arguments, corner));
        }
    }
    if (request.points() > points_max) {
        throw input_error("map: " + std::to_string(request.points()) + " points are more than the " +
                          std::to_string(points_max) + " that a map can have");
    }
    return request;
}

double coupled_damped_frequency_Hz(const rig &rig)
{
    const double damping_ratio = map_point_of(rig).damping_ratio;
    const double w2 = (rig.firmware.manipulator.stiffness_N_per_m + rig.object.stiffness_N_per_m) /
                      (rig.firmware.manipulator.mass_kg + rig.object.mass_kg);
    return std::sqrt(std::max(0.0, w2 * (1.0 - damping_ratio * damping_ratio))) / (2.0 * pi);
}

std::string axis_title(const map_axis &axis)
{
    return axis.name == frequency_ratio_axis ? "omega/omega_M" : axis.name;
}

} // namespace berth
