#include "wrench.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Dense>

#include "../../firmware/arm/sine.h"
#include "../../firmware/sensor_layout.h"
#include "sections.h"

namespace berth
{

namespace
{

using matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

/* Beyond these a mounting is a slip of the keyboard. */
constexpr double mounting_angle_max_rad = 10.0;
constexpr double mounting_way_max_m = 100.0;

/* A calibration that is nearer to a singular one than this would make force of noise. */
constexpr double condition_max = 1e6;

/* A sensor that shows forces this much too large or too small is one in other units. */
constexpr double shown_size_max = 1e3;

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
            wrench.crosstalk[6 * i + j] = finite_number(wrong.key, *row->get(j), origin);
        }
    }
}

constexpr std::array<section_key, 6> mounting = {{
    {"roll_rad", "the sensor's axes in the robot's frame: about x first", -mounting_angle_max_rad,
     mounting_angle_max_rad},
    {"pitch_rad", "then about y", -mounting_angle_max_rad, mounting_angle_max_rad},
    {"yaw_rad", "then about z", -mounting_angle_max_rad, mounting_angle_max_rad},
    {"x_m", "the sensor's origin in the robot's frame, from the tool's point", -mounting_way_max_m,
     mounting_way_max_m},
    {"y_m", "the same along y", -mounting_way_max_m, mounting_way_max_m},
    {"z_m", "the same along z", -mounting_way_max_m, mounting_way_max_m},
}};

std::string mounting_names()
{
    std::array<std::string, mounting.size()> names;
    std::transform(mounting.begin(), mounting.end(), names.begin(), [](const section_key &key) { return key.name; });
    return list_of(names);
}

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

} // namespace

void read_wrench(rig &rig, const toml::table &table, const std::string &origin)
{
    rig.wrench.enabled = true;
    for (const auto &[entry, value] : table) {
        const auto found =
            std::find_if(mounting.begin(), mounting.end(),
                         [&, &entry = entry](const section_key &key) { return key.name == entry.str(); });
        const std::string path = "wrench." + std::string(entry.str());
        if (entry.str() == "crosstalk") {
            read_crosstalk(rig.wrench, value, origin);
        } else if (entry.str() == "torque_noise_N_m") {
            rig.wrench.torque_noise_N_m = finite_number(path, value, origin);
        } else if (found == mounting.end()) {
            fail(place(origin, value.source()),
                 {path, "unknown; there are " + mounting_names() + ", torque_noise_N_m and crosstalk"});
        } else {
            const auto which = static_cast<std::size_t>(found - mounting.begin());
            const double size = finite_number(path, value, origin);
            if (size < found->low || size > found->high) {
                fail(place(origin, value.source()), {path, "must be within +-" + number_text(found->high)});
            }
            (which < 3 ? rig.wrench.angles_rad[which] : rig.wrench.origin_m[which - 3]) = size;
        }
    }
}

std::vector<section_key> wrench_keys()
{
    std::vector<section_key> keys(mounting.begin(), mounting.end());
    keys.push_back({"torque_noise_N_m", "noise of the torques, standard deviation", 0.0});
    keys.push_back(
        {"crosstalk", "six rows of six numbers: what the sensor shows of force x, y, z and torque x, y, z"});
    return keys;
}

void print_wrench(const wrench_rig &wrench, std::ostream &text)
{
    if (!wrench.enabled) {
        return;
    }
    text << "\n[wrench]\n";
    for (std::size_t i = 0; i < 6; i++) {
        text << mounting[i].name << " = " << number_text(i < 3 ? wrench.angles_rad[i] : wrench.origin_m[i - 3])
             << "\n";
    }
    text << "torque_noise_N_m = " << number_text(wrench.torque_noise_N_m) << "\n";
    text << "crosstalk = [";
    for (std::size_t i = 0; i < 36; i++) {
        text << (i % 6 == 0 ? "[" : "") << number_text(wrench.crosstalk[i])
             << (i == 35      ? "]]\n"
                 : i % 6 == 5 ? "], "
                              : ", ");
    }
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
    const double size = values.singularValues()(0);
    if (!(size < shown_size_max && size * shown_size_max > 1.0)) {
        return rig_error{"wrench.crosstalk", "shows loads " + number_text(size) +
                                                 " times as large as they are: must be from " +
                                                 number_text(1.0 / shown_size_max) + " to " +
                                                 number_text(shown_size_max) + " times, in N and N m"};
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

} // namespace berth
