#include "arm_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "../../firmware/arm/sine.h"
#include "arm_keys.h"
#include "arm_table.h"
#include "names.h"
#include "rig_file.h"
#include "robot_file.h"
#include "toml_file.h"

namespace berth
{

namespace
{

struct axes_of_turn {
    double rows[9];
};

/* URDF's: about fixed x by roll, then y by pitch, then z by yaw. */
axes_of_turn from_rpy(const std::array<double, 3> &rpy_rad)
{
    const sine_cosine r = sine_and_cosine(rpy_rad[0]);
    const sine_cosine p = sine_and_cosine(rpy_rad[1]);
    const sine_cosine y = sine_and_cosine(rpy_rad[2]);
    return {{y.cosine * p.cosine, y.cosine * p.sine * r.sine - y.sine * r.cosine,
             y.cosine * p.sine * r.cosine + y.sine * r.sine, y.sine * p.cosine,
             y.sine * p.sine * r.sine + y.cosine * r.cosine, y.sine * p.sine * r.cosine - y.cosine * r.sine, -p.sine,
             p.cosine * r.sine, p.cosine * r.cosine}};
}

/* Reads one section after another and remembers where keys stood. */
class reader
{
  public:
    explicit reader(std::string origin) : origin_(std::move(origin)) {}

    std::string where(const toml::node &node) const { return place(origin_, node.source()); }
    std::string where(const std::string &path) const
    {
        for (std::string at = path; !at.empty(); at = at.substr(0, at.rfind('.'))) {
            if (const auto found = places_.find(at); found != places_.end()) {
                return found->second;
            }
            if (at.find('.') == std::string::npos) {
                break;
            }
        }
        return origin_ + " (default value)";
    }

    double number(const std::string &path, const toml::node &node)
    {
        const auto value = node.value<double>();
        if (!node.is_number() || !value) {
            fail(where(node), {path, "must be a number (is " + text_of(node) + ")"});
        }
        return *value;
    }

    void numbers(const std::string &path, const toml::node &node, double *values, std::size_t count)
    {
        places_[path] = where(node);
        if (count == 1 && node.is_number()) {
            *values = number(path, node);
            return;
        }
        const toml::array *const array = node.as_array();
        if (array == nullptr || array->size() != count) {
            fail(where(node), {path, count == 1 ? "must be a number (is " + text_of(node) + ")"
                                                : "must be " + std::to_string(count) + " numbers in brackets"});
        }
        for (std::size_t i = 0; i < count; i++) {
            values[i] = number(path, *array->get(i));
        }
    }

    template <std::size_t Count>
    std::int32_t choice(const std::string &path, const toml::node &node,
                        const std::array<std::string_view, Count> &words)
    {
        places_[path] = where(node);
        std::string known;
        for (std::size_t i = 0; i < Count; i++) {
            if (node.value<std::string>() == words[i]) {
                return static_cast<std::int32_t>(i);
            }
            known += (i == 0 ? "\"" : ", \"") + std::string(words[i]) + "\"";
        }
        fail(where(node), {path, "must be one of " + known + " (is " + text_of(node) + ")"});
    }

    std::int64_t whole(const std::string &path, const toml::node &node)
    {
        places_[path] = where(node);
        if (!node.is_integer()) {
            fail(where(node), {path, "must be a whole number (is " + text_of(node) + ")"});
        }
        return node.as_integer()->get();
    }

    bool boolean(const std::string &path, const toml::node &node)
    {
        places_[path] = where(node);
        if (!node.is_boolean()) {
            fail(where(node), {path, "must be true or false (is " + text_of(node) + ")"});
        }
        return node.as_boolean()->get();
    }

    const toml::table &table(const std::string &path, const toml::node &node)
    {
        places_[path] = where(node);
        if (node.as_table() == nullptr) {
            fail(where(node), {path, "must be a section"});
        }
        return *node.as_table();
    }

    [[noreturn]] void unknown(const std::string &path, const toml::node &node, const std::string &known)
    {
        fail(where(node), {path, "unknown key; there are " + known});
    }

    /* True if the key is one of these and has been read. */
    template <class Keys>
    bool number_of(const Keys &keys, const std::string &section, std::string_view name, const toml::node &node,
                   void *object)
    {
        for (const number_key &key : keys) {
            if (key.name == name) {
                auto *const values = reinterpret_cast<double *>(static_cast<char *>(object) + key.offset);
                numbers(section + "." + std::string(name), node, values, key.count);
                return true;
            }
        }
        return false;
    }

    bool frame(const std::string &section, std::string_view name, const toml::node &node, arm_frame &frame)
    {
        if (name == "rpy_rad") {
            std::array<double, 3> rpy_rad{};
            numbers(section + ".rpy_rad", node, rpy_rad.data(), 3);
            if (!std::all_of(rpy_rad.begin(), rpy_rad.end(),
                             [](double angle_rad) { return std::abs(angle_rad) <= ARM_ANGLE_MAX_rad; })) {
                fail(where(node), {section + ".rpy_rad", "must be within 1e6 rad; leave whole turns out"});
            }
            const axes_of_turn axes = from_rpy(rpy_rad);
            std::copy(std::begin(axes.rows), std::end(axes.rows), frame.axes);
            return true;
        }
        return number_of(frame_keys, section, name, node, &frame);
    }

  private:
    std::string origin_;
    key_places places_;
};

template <class Keys>
std::string names_of(const Keys &keys, std::string names = "")
{
    for (const number_key &key : keys) {
        names += (names.empty() ? "" : ", ") + std::string(key.name);
    }
    return names;
}

void read_body(reader &reader, const std::string &section, const toml::node &node, arm_body &body)
{
    for (const auto &[name, value] : reader.table(section, node)) {
        if (!reader.number_of(body_keys, section, name.str(), value, &body)) {
            reader.unknown(section + "." + std::string(name.str()), value, names_of(body_keys));
        }
    }
}

constexpr double upright[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

void read_joint(reader &reader, const std::string &section, const toml::node &node, arm_description &arm)
{
    arm_joint &joint = arm.config.joints[arm.config.joint_count];
    joint = {};
    std::copy(std::begin(upright), std::end(upright), joint.frame.axes);
    joint.axis[2] = 1.0;
    joint.gear_ratio = 1.0;
    joint.torque_limit_N_m = joint.rate_limit_rad_per_s = joint.acceleration_limit_rad_per_s2 = never;
    joint.angle_min_rad = -never;
    joint.angle_max_rad = never;
    std::string name = "joint " + std::to_string(arm.config.joint_count + 1);
    std::string name_place = reader.where(node);
    for (const auto &[key, value] : reader.table(section, node)) {
        if (key.str() == "name") {
            name_place = reader.where(value);
            name = read_text(section + ".name", value, name_place);
        } else if (key.str() == "link") {
            read_body(reader, section + ".link", value, joint.link);
        } else if (!reader.frame(section, key.str(), value, joint.frame) &&
                   !reader.number_of(joint_keys, section, key.str(), value, &joint)) {
            reader.unknown(section + "." + std::string(key.str()), value,
                           names_of(joint_keys, "name, link, rpy_rad, " + names_of(frame_keys)));
        }
    }
    if (std::find(arm.joint_names.begin(), arm.joint_names.end(), name) != arm.joint_names.end()) {
        fail(name_place, {section + ".name", "there are two joints \"" + name + "\"; each needs a name of its own"});
    }
    arm.joint_names.push_back(name);
    arm.config.joint_count++;
}

void read_joints(reader &reader, const toml::node &node, arm_description &arm)
{
    const toml::array *const joints = node.as_array();
    if (joints == nullptr || joints->size() > ARM_JOINTS_MAX) {
        fail(reader.where(node),
             {"joint", "must be 1 to " + std::to_string(ARM_JOINTS_MAX) + " sections [[joint]]"});
    }
    for (const toml::node &joint : *joints) {
        read_joint(reader, "joint." + std::to_string(arm.config.joint_count + 1), joint, arm);
    }
}

void read_base(reader &reader, const toml::node &node, arm_config &config)
{
    for (const auto &[name, value] : reader.table("base", node)) {
        const std::string path = "base." + std::string(name.str());
        if (name.str() == "is_free") {
            config.base_is_free = reader.boolean(path, value) ? 1 : 0;
        } else if (name.str() == "position_m") {
            reader.numbers(path, value, config.base_position_m, 3);
        } else if (name.str() == "turn_rad" && config.kind == ARM_PLANAR) {
            reader.numbers(path, value, config.base_attitude, 1);
        } else if (name.str() == "quaternion" && config.kind == ARM_SPATIAL) {
            reader.numbers(path, value, config.base_attitude, 4);
        } else if (name.str() == "gravity_m_per_s2") {
            reader.numbers(path, value, config.gravity_m_per_s2, 3);
        } else if (!reader.number_of(body_keys, "base", name.str(), value, &config.base)) {
            reader.unknown(path, value,
                           names_of(body_keys, config.kind == ARM_PLANAR
                                                   ? "is_free, position_m, turn_rad, gravity_m_per_s2"
                                                   : "is_free, position_m, quaternion, gravity_m_per_s2"));
        }
    }
}

void read_attitude(reader &reader, const toml::node &node, attitude_config &attitude)
{
    for (const auto &[name, value] : reader.table("attitude", node)) {
        const std::string path = "attitude." + std::string(name.str());
        if (name.str() == "actuator") {
            attitude.actuator = reader.choice(path, value, actuator_words);
        } else if (name.str() == "period_ticks") {
            attitude.period_ticks = reader.whole(path, value);
        } else if (!reader.number_of(attitude_keys, "attitude", name.str(), value, &attitude)) {
            reader.unknown(path, value, names_of(attitude_keys, "actuator, period_ticks"));
        }
    }
}

void read_section(reader &reader, std::string_view name, const toml::node &node, arm_description &arm)
{
    arm_config &config = arm.config;
    if (name == "base") {
        read_base(reader, node, config);
    } else if (name == "joint") {
        read_joints(reader, node, arm);
    } else if (name == "tool") {
        for (const auto &[key, value] : reader.table("tool", node)) {
            if (!reader.frame("tool", key.str(), value, config.tool)) {
                reader.unknown("tool." + std::string(key.str()), value, names_of(frame_keys, "rpy_rad"));
            }
        }
    } else if (name == "payload") {
        read_body(reader, "payload", node, config.payload);
    } else if (name == "attitude") {
        read_attitude(reader, node, config.attitude);
    } else if (name == "integrator") {
        config.integrator = reader.choice("integrator", node, integrator_words);
    } else if (name == "force") {
        config.force = reader.choice("force", node, force_words);
    } else if (name == "substeps") {
        config.substeps = reader.whole("substeps", node);
    } else if (name == "name") {
        arm.name = read_file_name("name", node, reader.where(node));
    } else if (name == "description") {
        arm.description = read_text("description", node, reader.where(node));
    } else if (name != "kind") {
        reader.unknown(std::string(name), node,
                       "name, description, kind, integrator, force, substeps, and the sections base, joint, tool, "
                       "payload, attitude");
    }
}

} // namespace

arm_description parse_arm(const std::string &text, const std::string &origin)
{
    return read_arm(parse_toml(text, origin), origin);
}

arm_description read_arm(const toml::table &table, const std::string &origin)
{
    reader reader(origin);
    arm_description arm;
    const toml::node *const kind = table.get("kind");
    if (kind == nullptr) {
        throw input_error(origin + ": kind: is missing; it must be \"planar\" or \"spatial\"");
    }
    arm.config.kind = reader.choice("kind", *kind, kind_words);
    if (arm.config.kind == ARM_NONE) {
        fail(reader.where(*kind), {"kind", "must be \"planar\" or \"spatial\""});
    }
    arm.config.base_attitude[0] = arm.config.kind == ARM_SPATIAL ? 1.0 : 0.0;
    for (const auto &[name, node] : table) {
        read_section(reader, name.str(), node, arm);
    }
    if (!table.contains("force")) {
        arm.config.force = arm_force_for(arm.config.integrator);
    }
    if (const arm_error error = arm_validate(&arm.config); error.key != nullptr) {
        std::string path = error.section;
        std::string spoken = path;
        if (path.substr(0, 5) == "joint" && arm.config.joint_count > 0) {
            path.insert(5, "." + std::to_string(error.joint + 1));
            spoken = path + " (" + arm.joint_names[static_cast<std::size_t>(error.joint)] + ")";
        }
        const std::string key = error.key[0] == '\0' ? "" : std::string(".") + error.key;
        fail(reader.where(path + key), {spoken + key, error.message});
    }
    return arm;
}

std::string read_arm_file(const std::string &path)
{
    std::string text = read_file(path, written_bytes_max);
    if (const std::int64_t line = line_of_xml(text); line > 0) {
        throw input_error(path + ":" + std::to_string(line) +
                          ": is XML, as URDF is, and no arm file; make one of it with `berth arm ROBOT.urdf --tool "
                          "LINK > ARM.toml`, the name of ROBOT ending in .urdf");
    }
    return text;
}

arm_description load_arm(const std::string &name_or_path)
{
    for (const auto &shipped : shipped_arms()) {
        if (name_or_path == shipped.name) {
            return parse_arm(shipped.text, name_or_path + ".toml");
        }
    }
    if (!looks_like_path(name_or_path) && !std::ifstream(name_or_path)) {
        std::string names;
        for (const auto &shipped : shipped_arms()) {
            names += (names.empty() ? "" : ", ") + std::string(shipped.name);
        }
        throw input_error(name_or_path + ": no shipped arm has this name (" + names + ") and there is no such file" +
                          did_you_mean(names_of_files(shipped_arms()), name_or_path));
    }
    const std::string text = read_arm_file(name_or_path);
    if (const toml::table table = parse_toml(text, name_or_path);
        !table.contains("kind") && table.contains("robot")) {
        throw input_error(name_or_path + ": is a rig file, and no arm file; `berth arm ess` prints an arm file");
    }
    arm_description arm = parse_arm(text, name_or_path);
    if (arm.name.empty()) {
        arm.name = stem_of(name_or_path);
    }
    return arm;
}

} // namespace berth
