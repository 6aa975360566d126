#include "axes.h"

#include <charconv>
#include <cmath>
#include <Eigen/Dense>

#include "../../firmware/arm/sine.h"
#include "../../firmware/sensor_layout.h"

namespace berth
{

namespace
{

using matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

constexpr std::array<std::string_view, SIDE_AXIS_COUNT> axis_names = {"y", "z", "rx", "ry", "rz"};

bool turns(std::size_t axis)
{
    return axis >= SIDE_AXIS_RX;
}

constexpr double not_told = -1.0; /* a dead time: the robot's own counts */

/* Beyond these a mounting is a slip of the keyboard. */
constexpr double mounting_angle_max_rad = 10.0;
constexpr double mounting_way_max_m = 100.0;

/* A calibration that is nearer to a singular one than this would make force of noise. */
constexpr double condition_max = 1e6;

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
    {"stiffness_N_per_m", "stiffness_N_m_per_rad", RIG_MEMBER(stiffness), 0.0, 1e13, "of the same"},
    {"damping_N_s_per_m", "damping_N_m_s_per_rad", RIG_MEMBER(damping), 0.0, 1e12, "of the same"},
    {"sensor_stiffness_N_per_m", "sensor_stiffness_N_m_per_rad", RIG_MEMBER(sensor_stiffness), 1e-6, 1e13,
     "between robot and object"},
    {"sensor_damping_ratio", "sensor_damping_ratio", RIG_MEMBER(sensor_damping_ratio), 0.0, 1e4, "of the same"},
    {"robot_dead_time_ms", "robot_dead_time_ms", RIG_MEMBER(dead_time_ms), 0.0, 1e5, "command to motion"},
    {"position_limit_m", "angle_limit_rad", LIMIT_MEMBER(limits.position_max_m), 1e-9, 1e9,
     "of setpoints, either way"},
    {"velocity_limit_m_per_s", "rate_limit_rad_per_s", LIMIT_MEMBER(limits.velocity_m_per_s), 1e-9, 1e9,
     "of setpoints"},
    {"acceleration_limit_m_per_s2", "acceleration_limit_rad_per_s2", LIMIT_MEMBER(limits.acceleration_m_per_s2),
     1e-9, 1e9, "of setpoints"},
    {"start_tolerance_m", "start_tolerance_rad", LIMIT_MEMBER(start_tolerance), 1e-12, 1e9,
     "robot to first setpoint"},
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

double number(const std::string &key, const toml::node &node, const std::string &origin)
{
    const auto value = node.value<double>();
    if (!node.is_number() || !value || !std::isfinite(*value)) {
        fail(place(origin, node.source()), {key, "must be a finite number (is " + text_of(node) + ")"});
    }
    return *value;
}

std::string number_text(double value)
{
    char digits[32];
    const auto [end, error] = std::to_chars(digits, digits + sizeof digits, value);
    return std::string(digits, end);
}

template <typename Names>
std::string list_of(const Names &names)
{
    std::string list;
    for (const auto &name : names) {
        list.append(list.empty() ? "" : ", ").append(name);
    }
    return list;
}

std::string keys_of(std::size_t axis)
{
    std::array<std::string, axis_keys.size()> names;
    for (std::size_t i = 0; i < names.size(); i++) {
        names[i] = name_of(axis_keys[i], axis);
    }
    return list_of(names);
}

void read_crosstalk(wrench_rig &wrench, const toml::node &node, const std::string &origin)
{
    const rig_error wrong{"wrench.crosstalk",
                          "must be six rows of six numbers: what the sensor shows of force x, y, "
                          "z and torque x, y, z"};
    const toml::array *const rows = node.as_array();
    if (rows == nullptr || rows->size() != 6) {
        fail(place(origin, node.source()), wrong);
    }
    for (std::size_t i = 0; i < 6; i++) {
        const toml::array *const row = rows->get(i)->as_array();
        if (row == nullptr || row->size() != 6) {
            fail(place(origin, rows->get(i)->source()), wrong);
        }
        for (std::size_t j = 0; j < 6; j++) {
            wrench.crosstalk[6 * i + j] = number(wrong.key, *row->get(j), origin);
        }
    }
}

constexpr std::array<std::string_view, 6> mounting_names = {"roll_rad", "pitch_rad", "yaw_rad", "x_m", "y_m", "z_m"};

matrix6 matrix_of(const wrench_matrix &values)
{
    return Eigen::Map<const matrix6>(values.data());
}

/* The sensor's axes in the robot's frame, as columns; with the firmware's own sine, so that a recorded run replays
 * to the same bits elsewhere. */
Eigen::Matrix3d mounted_axes(const wrench_rig &wrench)
{
    const auto about = [&](std::size_t axis) {
        const sine_cosine turn = sine_and_cosine(wrench.angles_rad[axis]);
        Eigen::Matrix3d turned = Eigen::Matrix3d::Identity();
        const auto i = static_cast<Eigen::Index>((axis + 1) % 3);
        const auto j = static_cast<Eigen::Index>((axis + 2) % 3);
        turned(i, i) = turned(j, j) = turn.cosine;
        turned(i, j) = -turn.sine;
        turned(j, i) = turn.sine;
        return turned;
    };
    return about(2) * about(1) * about(0);
}

std::optional<rig_error> complete_wrench(rig &rig)
{
    wrench_config &firmware = rig.firmware.wrench;
    firmware.enabled = rig.wrench.enabled || rig.has_side_axes();
    if (firmware.enabled == 0) {
        return {};
    }
    if (!(rig.wrench.torque_noise_N_m >= 0.0)) {
        return rig_error{"wrench.torque_noise_N_m", "must be 0 or more"};
    }
    const matrix6 shown = matrix_of(shown_wrench(rig.wrench));
    const Eigen::JacobiSVD<matrix6> values(matrix_of(rig.wrench.crosstalk));
    if (!(values.singularValues()(5) * condition_max > values.singularValues()(0))) {
        return rig_error{"wrench.crosstalk",
                         "cannot be undone: it is singular, or so near to it that noise would be "
                         "all that is left"};
    }
    Eigen::Map<matrix6>(firmware.to_robot) = shown.inverse();
    const std::int32_t layout = rig.firmware.sensor_channel.layout;
    if (layout >= 0 && layout < SENSOR_LAYOUT_COUNT && sensor_layouts[layout].axis_count == 1) {
        return rig_error{rig.wrench.enabled ? "wrench" : "axis",
                         "needs a sensor that shows forces and torques: sensor_channel.layout with two or three "
                         "frames"};
    }
    return {};
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
        return rig_error{path, "needs a gripped object: object.kind = \"gripped\""};
    }
    if (rig.run.grip_close_s > 0.0 || rig.run.grip_release_s < never) {
        return rig_error{path, "is gripped before the run and stays so: leave out run.grip_close_s and "
                               "run.grip_release_s, or this axis"};
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
    const double shortest_ms = 1e-6 * static_cast<double>(config_period_ns(&rig.firmware));
    if (rig.robot.interpolation == interpolation::linear && rig.side_axes[axis].dead_time_ms < shortest_ms) {
        return rig_error{path + ".robot_dead_time_ms", "must be a period at least, " + number_text(shortest_ms) +
                                                           " ms: the robot moves on straight lines"};
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
        *key->member(rig, axis) = number(path, value, origin);
        if (key->least == 0.0 && *key->member(rig, axis) < 0.0) {
            fail(place(origin, value.source()), {path, "must be 0 or more"});
        }
    }
}

void follow_dead_time(rig &rig)
{
    for (side_axis_rig &axis : rig.side_axes) {
        axis.dead_time_ms = not_told;
    }
}

void read_wrench(rig &rig, const toml::table &table, const std::string &origin)
{
    rig.wrench.enabled = true;
    for (const auto &[entry, value] : table) {
        const auto found = std::find(mounting_names.begin(), mounting_names.end(), entry.str());
        const std::string path = "wrench." + std::string(entry.str());
        if (entry.str() == "crosstalk") {
            read_crosstalk(rig.wrench, value, origin);
        } else if (entry.str() == "torque_noise_N_m") {
            rig.wrench.torque_noise_N_m = number(path, value, origin);
        } else if (found == mounting_names.end()) {
            fail(place(origin, value.source()),
                 {path, "unknown; there are " + list_of(mounting_names) + ", torque_noise_N_m and crosstalk"});
        } else {
            const auto which = static_cast<std::size_t>(found - mounting_names.begin());
            const double most = which < 3 ? mounting_angle_max_rad : mounting_way_max_m;
            const double size = number(path, value, origin);
            if (std::abs(size) > most) {
                fail(place(origin, value.source()), {path, "must be within +-" + number_text(most)});
            }
            (which < 3 ? rig.wrench.angles_rad[which] : rig.wrench.origin_m[which - 3]) = size;
        }
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
    if (!rig.wrench.enabled) {
        return;
    }
    text << "\n[wrench]\n";
    for (std::size_t i = 0; i < 6; i++) {
        text << mounting_names[i] << " = "
             << number_text(i < 3 ? rig.wrench.angles_rad[i] : rig.wrench.origin_m[i - 3]) << "\n";
    }
    text << "torque_noise_N_m = " << number_text(rig.wrench.torque_noise_N_m) << "\n";
    text << "crosstalk = [";
    for (std::size_t i = 0; i < 36; i++) {
        text << (i % 6 == 0 ? "[" : "") << number_text(rig.wrench.crosstalk[i])
             << (i == 35      ? "]]\n"
                 : i % 6 == 5 ? "], "
                              : ", ");
    }
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

/* Force turns with the axes; torque is moved to the sensor's origin first. */
wrench_matrix shown_wrench(const wrench_rig &wrench)
{
    const Eigen::Matrix3d to_sensor = mounted_axes(wrench).transpose();
    const auto &[x, y, z] = wrench.origin_m;
    Eigen::Matrix3d lever; /* lever * force = origin x force */
    lever << 0.0, -z, y, z, 0.0, -x, -y, x, 0.0;
    matrix6 mounted = matrix6::Zero();
    mounted.topLeftCorner<3, 3>() = to_sensor;
    mounted.bottomRightCorner<3, 3>() = to_sensor;
    mounted.bottomLeftCorner<3, 3>() = -to_sensor * lever;
    wrench_matrix shown;
    Eigen::Map<matrix6>(shown.data()) = matrix_of(wrench.crosstalk) * mounted;
    return shown;
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
    return complete_wrench(rig);
}

} // namespace berth
