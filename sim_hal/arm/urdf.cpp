#include "urdf.h"

#include <algorithm>
#include <Eigen/Geometry>
#include <map>
#include <sstream>

#include "../../hal/rig/toml_file.h"
#include "urdf_chain.h"
#include "urdf_model.h"

namespace berth
{

namespace
{

void write_frame(const urdf_frame &from, arm_frame &to)
{
    Eigen::Map<Eigen::Vector3d>(to.origin_m) = from.origin_m;
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(to.axes) = from.axes;
}

void write_body(const urdf_body &from, arm_body &to)
{
    const Eigen::Matrix3d &i = from.inertia_kg_m2;
    to.mass_kg = from.mass_kg;
    Eigen::Map<Eigen::Vector3d>(to.centre_m) = from.centre_m;
    const double parts[] = {i(0, 0), i(0, 1), i(0, 2), i(1, 1), i(1, 2), i(2, 2)};
    std::copy(std::begin(parts), std::end(parts), to.inertia_kg_m2);
}

/* What URDF does not say: a joint with harmonic drive as in arms of a few kg, to be replaced in the arm file. */
arm_joint stand_in_joint()
{
    arm_joint joint = {};
    joint.stiffness_N_m_per_rad = 1e4;
    joint.damping_N_m_s_per_rad = 10.0;
    joint.rotor_inertia_kg_m2 = 1e-4;
    joint.gear_ratio = 100.0;
    joint.servo_frequency_Hz = 10.0;
    joint.servo_damping_ratio = 0.7;
    joint.torque_limit_N_m = joint.rate_limit_rad_per_s = joint.acceleration_limit_rad_per_s2 = never;
    joint.angle_min_rad = -never;
    joint.angle_max_rad = never;
    return joint;
}

arm_joint make_joint(const urdf_model &model, const urdf_joint &from, const urdf_frame &placement)
{
    arm_joint joint = stand_in_joint();
    write_frame(placement, joint.frame);
    Eigen::Map<Eigen::Vector3d>(joint.axis) = from.axis;
    if (const urdf_element *const limit = from.xml->FirstChildElement("limit")) {
        const urdf_range range = model.range_of(from);
        if (!(range.upper > range.lower)) {
            model.fail(limit, "upper must be greater than lower; or hold the joint, with --hold " + from.name);
        }
        joint.angle_min_rad = range.lower;
        joint.angle_max_rad = range.upper;
        const auto positive = [&](const char *key) {
            const double value = limit->Attribute(key) == nullptr ? 0.0 : model.number(limit, key);
            if (value < 0.0) {
                model.fail(limit,
                           std::string(key) + " must not be negative; without it the joint has no such limit");
            }
            return value > 0.0 ? value : never;
        };
        joint.torque_limit_N_m = positive("effort");
        joint.rate_limit_rad_per_s = positive("velocity");
    } else if (from.motion == urdf_motion::revolute) {
        model.fail(from.xml, "a revolute joint needs <limit>; one that turns freely is \"continuous\"");
    }
    joint.initial_rad = resting_value(model, from, true);
    return joint;
}

/* How far a joint takes its link from the placement. */
urdf_frame displacement(const urdf_joint &joint, double value)
{
    switch (joint.motion) {
    case urdf_motion::revolute:
    case urdf_motion::continuous:
        return {Eigen::Vector3d::Zero(), Eigen::AngleAxisd(value, joint.axis).toRotationMatrix()};
    case urdf_motion::prismatic:
        return {value * joint.axis, Eigen::Matrix3d::Identity()};
    default:
        return {};
    }
}

/* The tree as an arm's bodies: that of the base, then that of each moving joint. */
struct assembly {
    std::vector<urdf_body> bodies;
    std::vector<urdf_frame> joints;              /* at the value 0, in the body before */
    urdf_frame tool;                             /* in the last body */
    std::vector<std::vector<std::string>> links; /* of each body, those that no body could be */
    std::size_t link_count = 0;                  /* that are part of it */
};

void add_link(const urdf_model &model, const std::string &link, const urdf_frame &frame, std::size_t body,
              assembly &made)
{
    made.bodies[body] = joined(made.bodies[body], frame * model.body_of(link));
    made.link_count++;
    if (model.doubt_about(link)) {
        made.links[body].push_back(link);
    }
}

assembly assemble(const urdf_model &model, const urdf_chain &chain, const std::vector<double> &held)
{
    struct place {
        std::size_t body;
        urdf_frame frame;
    };
    std::map<std::string, place> places = {{chain.base, {0, {}}}};
    assembly made;
    made.bodies.resize(chain.moving.size() + 1);
    made.links.resize(made.bodies.size());
    add_link(model, chain.base, {}, 0, made);
    for (std::size_t i = 0; i < model.joints().size(); i++) {
        const urdf_joint &joint = model.joints()[i];
        const auto parent = places.find(joint.parent);
        if (parent == places.end() || joint.motion == urdf_motion::floating) {
            continue;
        }
        const urdf_frame placement = parent->second.frame * joint.placement;
        place child = {parent->second.body, placement * displacement(joint, held[i])};
        if (std::find(chain.moving.begin(), chain.moving.end(), i) != chain.moving.end()) {
            made.joints.push_back(placement);
            child = {made.joints.size(), {}};
        }
        places[joint.child] = child;
        add_link(model, joint.child, child.frame, child.body, made);
    }
    made.tool = places.at(chain.tool).frame;
    return made;
}

/* A root that has no mass is no satellite, all the more one that is called so. */
bool is_on_the_ground(const urdf_model &model, const urdf_chain &chain, const urdf_body &base)
{
    const bool is_world = chain.base == "world" && model.body_of(chain.base).mass_kg == 0.0;
    return !chain.floats && (is_world || base.mass_kg == 0.0);
}

/* A link that no body could be is used where the body that it is part of is one by all but 5 %, as most are that
 * only stand in for a frame. */
std::vector<std::string> judge_inertia(const urdf_model &model, const assembly &made, bool base_is_free)
{
    std::vector<std::string> warnings;
    for (std::size_t i = 0; i < made.bodies.size(); i++) {
        const urdf_body &body = made.bodies[i];
        const inertia_fault fault = inertia_fault_of(body.inertia_kg_m2);
        const bool counts = i > 0 || base_is_free || body.mass_kg > 0.0;
        const bool is_one = !fault.is_negative && fault.excess <= ARM_INERTIA_EXCESS_MAX && body.mass_kg > 0.0;
        for (const std::string &link : made.links[i]) {
            const urdf_element *const at = model.inertia_xml(link);
            if (counts && !is_one) {
                model.fail(at, *model.doubt_about(link) +
                                   (body.mass_kg > 0.0 ? ". In the plane, with --planar, izz alone counts" : ""));
            }
            warnings.push_back(
                model.place(at) + ": " + *model.doubt_about(link) +
                (counts ? ". It is used as it is" : ". The base is held, and its inertia does not count"));
        }
    }
    return warnings;
}

std::string text_of(double value)
{
    std::ostringstream text;
    text.precision(4);
    text << value;
    return text.str();
}

std::string value_text(const urdf_joint &joint, double value)
{
    if (joint.motion == urdf_motion::planar) {
        return "its origin";
    }
    return number_text(value) + (joint.motion == urdf_motion::prismatic ? " m" : " rad");
}

/* "Held: a at 0 rad, b at 0.02 m", the first `most` of them. */
std::string note_of_held(const urdf_model &model, const urdf_chain &chain, const std::vector<double> &held,
                         std::size_t most)
{
    std::string names;
    std::size_t count = 0;
    for (std::size_t i = 0; i < held.size(); i++) {
        const urdf_joint &joint = model.joints()[i];
        const bool is_moving = std::find(chain.moving.begin(), chain.moving.end(), i) != chain.moving.end();
        if (joint.motion == urdf_motion::fixed || joint.motion == urdf_motion::floating || is_moving) {
            continue;
        }
        if (count++ < most) {
            names += (names.empty() ? "Held: " : ", ") + joint.name + " at " + value_text(joint, held[i]);
        }
    }
    return names + (count > most ? " and " + std::to_string(count - most) + " more" : "");
}

std::vector<std::string> notes_on(const urdf_model &model, const urdf_choice &choice, const urdf_chain &chain,
                                  const assembly &made, bool is_free)
{
    std::vector<std::string> notes = {"From URDF: motors, springs and servos are stand-ins until somebody states "
                                      "them"};
    notes.push_back((choice.tool.empty() ? "The arm is the longest movable chain, " : "The arm is ") +
                    std::to_string(chain.moving.size()) +
                    (chain.moving.size() == 1 ? " joint from link " : " joints from link ") + chain.base +
                    " to link " + chain.tool +
                    (chain.movable > chain.moving.size() ? ", the first of the " + std::to_string(chain.movable) +
                                                               " that could move; with --hold others have their turn"
                                                         : ""));
    notes.push_back("The base, link " + chain.base +
                    (is_free ? ", is a free satellite of " + text_of(made.bodies[0].mass_kg) + " kg"
                             : ", has no mass: it is held, as that of an arm on the ground (base.is_free = false)"));
    const std::size_t left_out = model.link_count() - made.link_count;
    if (left_out > 0) {
        notes.push_back(std::to_string(left_out) + (left_out == 1
                                                        ? " link is left out: it does not hang on the base"
                                                        : " links are left out: they do not hang on the base"));
    }
    std::string without_range;
    for (const std::size_t i : chain.moving) {
        const urdf_joint &joint = model.joints()[i];
        if (joint.motion == urdf_motion::revolute && !model.range_of(joint).is_stated) {
            without_range += (without_range.empty() ? "" : ", ") + joint.name;
        }
    }
    if (!without_range.empty()) {
        notes.push_back("Without limits of the angle, as the file states none: " + without_range);
    }
    const bool leaves_dynamics = std::any_of(chain.moving.begin(), chain.moving.end(), [&](std::size_t i) {
        return model.joints()[i].xml->FirstChildElement("dynamics") != nullptr;
    });
    if (leaves_dynamics) {
        notes.push_back("<dynamics> of its joints is left out");
    }
    return notes;
}

void check(const urdf_model &model, const urdf_chain &chain, const arm_config &config)
{
    const arm_error error = arm_validate(&config);
    if (error.key == nullptr) {
        return;
    }
    const std::string section = error.section;
    const std::string message = (*error.key != '\0' ? error.key + std::string(": ") : "") + error.message;
    if (section.rfind("joint", 0) == 0) {
        const urdf_joint &joint = model.joints()[chain.moving[static_cast<std::size_t>(error.joint)]];
        model.fail(joint.xml, (section == "joint.link" ? "the link on it, with what is fixed to it: " : "") +
                                  message + "; the arm does without the joint with --hold " + joint.name);
    }
    model.fail(section + (section == "base" ? " (link \"" + chain.base + "\")" : "") + ": " + message);
}

constexpr std::size_t held_names_max = 16; /* in a description, which is short; notes have all */

} // namespace

urdf_arm arm_from_urdf(const std::string &text, const std::string &origin, const urdf_choice &choice)
{
    const urdf_model model(text, origin);
    const urdf_chain chain = choose_chain(model, choice);
    urdf_arm arm;
    const std::vector<double> held = held_values(model, choice, chain.moving, arm.warnings);
    const assembly made = assemble(model, chain, held);

    arm.name = model.name();
    arm_config &config = arm.config;
    config.kind = choice.is_planar ? ARM_PLANAR : ARM_SPATIAL;
    config.base_attitude[0] = choice.is_planar ? 0.0 : 1.0;
    config.base_is_free = is_on_the_ground(model, chain, made.bodies[0]) ? 0 : 1;
    if (!choice.is_planar) {
        for (std::string &warning : judge_inertia(model, made, config.base_is_free != 0)) {
            arm.warnings.push_back(std::move(warning));
        }
    }
    if (config.base_is_free != 0 || made.bodies[0].mass_kg > 0.0) {
        write_body(made.bodies[0], config.base);
    }
    for (std::size_t i = 0; i < chain.moving.size(); i++) {
        const urdf_joint &joint = model.joints()[chain.moving[i]];
        arm_joint &to = config.joints[config.joint_count++];
        to = make_joint(model, joint, made.joints[i]);
        write_body(made.bodies[i + 1], to.link);
        arm.joint_names.push_back(joint.name);
    }
    write_frame(made.tool, config.tool);
    check(model, chain, config);

    arm.notes = notes_on(model, choice, chain, made, config.base_is_free != 0);
    const auto add_held = [&](std::vector<std::string> notes, std::size_t most) {
        const std::string note = note_of_held(model, chain, held, most);
        if (!note.empty()) {
            notes.push_back(note);
        }
        return notes;
    };
    for (const std::string &note : add_held(arm.notes, held_names_max)) {
        arm.description += (arm.description.empty() ? "" : ". ") + note;
    }
    arm.notes = add_held(arm.notes, held.size());
    return arm;
}

} // namespace berth
