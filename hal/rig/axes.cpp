#include "axes.h"

#include <algorithm>
#include <cmath>

#include "sections.h"
#include "wrench.h"

namespace berth
{

namespace
{

constexpr auto axis_names = side_axis_names;

bool turns(std::size_t axis)
{
    return axis >= SIDE_AXIS_RX;
}

constexpr double not_told = -1.0; /* a dead time: the robot's own counts */

/* Shown to the robot in whole frames; a rotation vector has two values for half a turn. */
constexpr double way_max_m = 5.4;
constexpr double angle_max_rad = 3.0;

struct axis_key {
    std::string_view way;  /* name of the key for an axis of ways ... */
    std::string_view turn; /* ... and of turns */
    double *(*member)(rig &, std::size_t);
    double least; /* 0: may be 0 */
    double most;
    std::string_view meaning;
};

#define RIG_MEMBER(name) [](rig &of, std::size_t axis) -> double * { return &of.side_axes[axis].name; }
#define LIMIT_MEMBER(name) [](rig &of, std::size_t axis) -> double * { return &of.firmware.side_axes[axis].name; }

constexpr std::array<axis_key, 10> axis_keys = {{
    {"mass_kg", "inertia_kg_m2", RIG_MEMBER(mass), 1e-6, 1e9, "of the object there"},
    {"stiffness_N_per_m", "stiffness_N_m_per_rad", RIG_MEMBER(stiffness), 0.0, 1e13, "of the object there"},
    {"damping_N_s_per_m", "damping_N_m_s_per_rad", RIG_MEMBER(damping), 0.0, 1e12, "of the object there"},
    {"sensor_stiffness_N_per_m", "sensor_stiffness_N_m_per_rad", RIG_MEMBER(sensor_stiffness), 1e-6, 1e13,
     "of the sensor between robot and object"},
    {"sensor_damping_ratio", "sensor_damping_ratio", RIG_MEMBER(sensor_damping_ratio), 0.0, 1e4,
     "of the sensor between robot and object"},
    {"robot_dead_time_ms", "robot_dead_time_ms", RIG_MEMBER(dead_time_ms), 0.0, 1e5,
     "command to motion along this axis"},
    {"position_limit_m", "angle_limit_rad", LIMIT_MEMBER(limits.position_max_m), 1e-9, 1e9,
     "largest setpoint, either way"},
    {"velocity_limit_m_per_s", "rate_limit_rad_per_s", LIMIT_MEMBER(limits.velocity_m_per_s), 1e-9, 1e9,
     "largest velocity of setpoints"},
    {"acceleration_limit_m_per_s2", "acceleration_limit_rad_per_s2", LIMIT_MEMBER(limits.acceleration_m_per_s2),
     1e-9, 1e9, "largest acceleration of setpoints"},
    {"start_tolerance_m", "start_tolerance_rad", LIMIT_MEMBER(start_tolerance), 1e-12, 1e9,
     "largest distance between the robot and the first setpoint"},
}};

#undef RIG_MEMBER
#undef LIMIT_MEMBER

std::string_view name_of(const axis_key &key, std::size_t axis)
{
    return turns(axis) ? key.turn : key.way;
}

/* Sensors and limits of the size in the paper; what else is not said is as along the loop's direction. */
void set_defaults(rig &rig, std::size_t axis)
{
    rig.side_axes[axis] = {};
    rig.side_axes[axis].dead_time_ms = not_told;
    rig.side_axes[axis].sensor_stiffness = turns(axis) ? 2e6 : 2e7;
    rig.firmware.side_axes[axis] = {1, 0.002, {-1.0, 1.0, 2.0, 50.0}};
}

std::string keys_of(std::size_t axis)
{
    std::array<std::string, axis_keys.size()> names;
    for (std::size_t i = 0; i < names.size(); i++) {
        names[i] = name_of(axis_keys[i], axis);
    }
    return list_of(names);
}

std::string wrong_size(const axis_key &key, double value)
{
    if (key.least == 0.0 ? value < 0.0 : value <= 0.0) {
        return std::string(key.least == 0.0 ? "must be 0 or more (" : "must be greater than 0 (")
            .append(key.meaning)
            .append(")");
    }
    return "must be from " + number_text(key.least) + " to " + number_text(key.most) + " (is " + number_text(value) +
           ")";
}

/* As that of the loop's axis. */
std::optional<rig_error> check_dead_time(const rig &rig, const std::string &path, double dead_time_ms)
{
    const double period_ms = 1e-6 * static_cast<double>(config_period_ns(&rig.firmware));
    if (rig.robot.interpolation == interpolation::linear && dead_time_ms < period_ms) {
        return rig_error{path + ".robot_dead_time_ms", "must be a period at least, " + number_text(period_ms) +
                                                           " ms: the robot moves on straight lines"};
    }
    const double bus_ms = 1e-6 * static_cast<double>(robot_frames_a_tick(rig) * frame_time_ns(rig.bus, 8));
    if (dead_time_ms < bus_ms) {
        return rig_error{path + ".robot_dead_time_ms",
                         "is shorter than the setpoint's time on the bus, which it includes (the other frames of a "
                         "tick go first: " +
                             number_text(bus_ms) + " ms); set bus.ideal = true"};
    }
    if (rig.run.dead_time_jump_s < never && dead_time_ms + rig.run.dead_time_jump_ms < 2.0 * period_ms) {
        return rig_error{"run.dead_time_jump_ms", "must leave " + path + " a dead time of 2 periods or more"};
    }
    return {};
}

std::optional<rig_error> check_axis(rig &rig, std::size_t axis)
{
    const std::string path = "axis." + std::string(axis_names[axis]);
    if (rig.firmware.arm.kind == ARM_NONE) {
        return rig_error{path,
                         "needs an arm, manipulator.arm: a manipulator of one degree of freedom moves along the "
                         "loop's direction alone"};
    }
    if (rig.firmware.arm.kind == ARM_PLANAR && axis != SIDE_AXIS_Y && axis != SIDE_AXIS_RZ) {
        return rig_error{path, "is none of a planar arm's: there are y and rz"};
    }
    if (rig.firmware.robot_channel.profile != ROBOT_PROFILE_BERTH) {
        return rig_error{path, "is spoken to by frames of berth.dbc alone: robot_channel.profile = \"berth\""};
    }
    if (rig.object.kind == object_kind::contact) {
        return rig_error{path, "needs a gripped object: object.kind = \"gripped\" or \"beam\""};
    }
    side_axis_config &config = rig.firmware.side_axes[axis];
    config.limits.position_min_m = -config.limits.position_max_m;
    for (const axis_key &key : axis_keys) {
        const double value = *key.member(rig, axis);
        if (!(value >= key.least && value <= key.most)) {
            return rig_error{path + "." + std::string(name_of(key, axis)), wrong_size(key, value)};
        }
    }
    const double most = turns(axis) ? angle_max_rad : way_max_m;
    if (config.limits.position_max_m > most) {
        return rig_error{path + "." + std::string(turns(axis) ? "angle_limit_rad" : "position_limit_m"),
                         "must be " + number_text(most) + " at most"};
    }
    return check_dead_time(rig, path, rig.side_axes[axis].dead_time_ms);
}

/* Beyond half a turn a rotation vector points the other way all at once. */
std::optional<rig_error> check_turns(const rig &rig)
{
    double square = 0.0;
    std::string_view last;
    for (std::size_t axis = SIDE_AXIS_RX; axis < SIDE_AXIS_COUNT; axis++) {
        const side_axis_config &config = rig.firmware.side_axes[axis];
        if (config.enabled != 0) {
            square += config.limits.position_max_m * config.limits.position_max_m;
            last = axis_names[axis];
        }
    }
    if (square > angle_max_rad * angle_max_rad) {
        return rig_error{"axis." + std::string(last) + ".angle_limit_rad",
                         "leads beyond half a turn together with those of the other axes: the root of the sum of "
                         "their squares must be " +
                             number_text(angle_max_rad) + " at most (is " + number_text(std::sqrt(square)) + ")"};
    }
    return {};
}

} // namespace

void read_axis(rig &rig, const std::string &name, const toml::node &node, const std::string &origin)
{
    const auto found = std::find(axis_names.begin(), axis_names.end(), name);
    const toml::table *const table = node.as_table();
    if (found == axis_names.end() || table == nullptr) {
        fail(place(origin, node.source()),
             {"axis." + name, "must be a section [axis.NAME] with one of the names " + list_of(axis_names)});
    }
    const auto axis = static_cast<std::size_t>(found - axis_names.begin());
    set_defaults(rig, axis);
    for (const auto &[entry, value] : *table) {
        const std::string path = "axis." + name + "." + std::string(entry.str());
        const auto key =
            std::find_if(axis_keys.begin(), axis_keys.end(),
                         [&, &entry = entry](const axis_key &known) { return name_of(known, axis) == entry.str(); });
        if (key == axis_keys.end()) {
            fail(place(origin, value.source()), {path, "unknown; there are " + keys_of(axis)});
        }
        *key->member(rig, axis) = finite_number(path, value, origin);
        if (key->least == 0.0 && *key->member(rig, axis) < 0.0) {
            fail(place(origin, value.source()), {path, "must be 0 or more"});
        }
    }
}

std::vector<section_key> side_axis_keys(std::size_t axis)
{
    std::vector<section_key> keys;
    keys.reserve(std::size(axis_keys));
    for (const axis_key &key : axis_keys) {
        keys.push_back({name_of(key, axis), key.meaning, key.least, key.most});
    }
    return keys;
}

void follow_dead_time(rig &rig)
{
    for (side_axis_rig &axis : rig.side_axes) {
        axis.dead_time_ms = not_told;
    }
}

void print_axes(const rig &rig, std::ostream &text)
{
    for (std::size_t axis = 0; axis < axis_names.size(); axis++) {
        if (rig.firmware.side_axes[axis].enabled == 0) {
            continue;
        }
        berth::rig copy = rig;
        text << "\n[axis." << axis_names[axis] << "]\n";
        for (const axis_key &key : axis_keys) {
            std::string line(name_of(key, axis));
            line.append(" = ").append(number_text(*key.member(copy, axis)));
            line.resize(std::max<std::size_t>(line.size(), 50), ' ');
            text << line << " # " << key.meaning << "\n";
        }
    }
    print_wrench(rig.wrench, text);
}

rig rig_along(const rig &whole, std::size_t axis)
{
    const side_axis_rig &side = whole.side_axes[axis];
    rig along = whole;
    along.robot.dead_time_ms = side.dead_time_ms;
    along.sensor.stiffness_N_per_m = side.sensor_stiffness;
    along.sensor.damping_ratio = side.sensor_damping_ratio;
    along.object = {};
    along.object.mass_kg = side.mass;
    along.object.stiffness_N_per_m = side.stiffness;
    along.object.damping_N_s_per_m = side.damping;
    along.firmware.manipulator.initial_position_m = 0.0;
    along.firmware.inverse_filter.enabled = 0;
    along.effect_values.fill(0.0);
    return along;
}

void move_dead_time(rig &rig, double dead_time_ms)
{
    const double more_ms = dead_time_ms - rig.robot.dead_time_ms;
    rig.robot.dead_time_ms = dead_time_ms;
    for (std::size_t axis = 0; axis < axis_names.size(); axis++) {
        if (rig.firmware.side_axes[axis].enabled != 0) {
            rig.side_axes[axis].dead_time_ms += more_ms;
        }
    }
}

std::optional<rig_error> complete_and_check_axes(rig &rig)
{
    for (std::size_t axis = 0; axis < axis_names.size(); axis++) {
        if (rig.firmware.side_axes[axis].enabled == 0) {
            continue;
        }
        if (rig.side_axes[axis].dead_time_ms < 0.0) {
            rig.side_axes[axis].dead_time_ms = rig.robot.dead_time_ms;
        }
        if (auto found = check_axis(rig, axis)) {
            return found;
        }
    }
    if (auto found = check_turns(rig)) {
        return found;
    }
    return complete_wrench(rig);
}

} // namespace berth
