#include "urdf.h"

#include <algorithm>

#include "../../hal/rig/rig.h"
#include "urdf_model.h"

namespace berth
{

namespace
{

/* The joints from base to tool, in this order. */
std::vector<const urdf_joint *> chain_of(const urdf_model &model, const std::string &base, const std::string &tool)
{
    std::vector<const urdf_joint *> chain;
    for (std::string at = tool; at != base;) {
        const urdf_joint *const joint = model.joint_to(at);
        if (joint == nullptr || chain.size() > model.joints().size()) {
            model.fail(
                std::string("link \"").append(tool).append("\" does not hang on link \"").append(base).append("\""));
        }
        chain.push_back(joint);
        at = joint->parent;
    }
    std::reverse(chain.begin(), chain.end());
    return chain;
}

std::string only_leaf(const urdf_model &model, const std::string &base)
{
    std::string at = base;
    for (;;) {
        std::string next;
        for (const urdf_joint &joint : model.joints()) {
            if (joint.parent == at) {
                if (!next.empty()) {
                    model.fail(joint.xml,
                               "link \"" + at + "\" branches; name the link at the arm's end with --tool");
                }
                next = joint.child;
            }
        }
        if (next.empty()) {
            return at;
        }
        at = next;
    }
}

/* A link and all that is fixed to it outside the chain. */
urdf_body with_fixed(const urdf_model &model, const std::string &link, const std::vector<const urdf_joint *> &chain)
{
    urdf_body body = model.body_of(link);
    for (const urdf_joint &joint : model.joints()) {
        const bool in_chain = std::any_of(chain.begin(), chain.end(), [&](auto *other) { return other == &joint; });
        if (joint.parent == link && !in_chain) {
            if (joint.type != "fixed") {
                model.fail(joint.xml, "moves beside the arm from base to tool; only fixed joints may");
            }
            body = joined(body, joint.placement * with_fixed(model, joint.child, chain));
        }
    }
    return body;
}

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
    if (const urdf_element *const mimic = from.xml->FirstChildElement("mimic")) {
        model.fail(mimic, "of joint \"" + from.name +
                              "\": the joints of an arm turn by themselves; make it fixed, or "
                              "choose another --tool");
    }
    arm_joint joint = stand_in_joint();
    write_frame(placement, joint.frame);
    Eigen::Map<Eigen::Vector3d>(joint.axis) = from.axis;
    if (const urdf_element *const limit = from.xml->FirstChildElement("limit")) {
        const auto or_zero = [&](const char *key) {
            return limit->Attribute(key) == nullptr ? 0.0 : model.number(limit, key);
        };
        if (from.type == "revolute") {
            joint.angle_min_rad = or_zero("lower");
            joint.angle_max_rad = or_zero("upper");
            if (!(joint.angle_max_rad > joint.angle_min_rad)) {
                model.fail(limit, "of joint \"" + from.name + "\": upper must be greater than lower");
            }
        }
        const auto positive = [&](const char *key) {
            const double value = or_zero(key);
            if (value < 0.0) {
                model.fail(limit, "of joint \"" + from.name + "\": " + key +
                                      " must not be negative; without it the joint has no such limit");
            }
            return value > 0.0 ? value : never;
        };
        joint.torque_limit_N_m = positive("effort");
        joint.rate_limit_rad_per_s = positive("velocity");
    } else if (from.type == "revolute") {
        model.fail(from.xml, "a revolute joint needs <limit>; one that turns freely is \"continuous\"");
    }
    joint.initial_rad = std::clamp(0.0, joint.angle_min_rad, joint.angle_max_rad);
    return joint;
}

} // namespace

arm_description arm_from_urdf(const std::string &text, const std::string &origin, const urdf_choice &choice)
{
    const urdf_model model(text, origin);
    const std::string base = choice.base.empty() ? model.root() : choice.base;
    if (!model.has_link(base)) {
        model.fail("there is no link \"" + base + "\" for --base");
    }
    if (!choice.tool.empty() && !model.has_link(choice.tool)) {
        model.fail("there is no link \"" + choice.tool + "\" for --tool");
    }
    const std::string tool = choice.tool.empty() ? only_leaf(model, base) : choice.tool;
    const std::vector<const urdf_joint *> chain = chain_of(model, base, tool);

    arm_description arm;
    arm.name = model.name();
    arm.description = "From URDF; motors, springs and servos are stand-ins until somebody states them";
    arm_config &config = arm.config;
    config.kind = choice.is_planar ? ARM_PLANAR : ARM_SPATIAL;
    config.base_attitude[0] = choice.is_planar ? 0.0 : 1.0;
    urdf_body body = with_fixed(model, base, chain);
    std::vector<const urdf_joint *> turning; /* those of the arm */
    bool leaves_dynamics = false;
    urdf_frame from_body; /* of the link reached, in the body that it belongs to */
    const auto close_body = [&] {
        write_body(body, config.joint_count == 0 ? config.base : config.joints[config.joint_count - 1].link);
    };
    for (const urdf_joint *joint : chain) {
        const urdf_frame placement = from_body * joint->placement;
        if (joint->type == "fixed") {
            body = joined(body, placement * with_fixed(model, joint->child, chain));
            from_body = placement;
            continue;
        }
        if (joint->type != "revolute" && joint->type != "continuous") {
            model.fail(joint->xml,
                       "is of type \"" + joint->type + "\"; the joints of an arm are revolute, continuous or fixed");
        }
        if (config.joint_count == ARM_JOINTS_MAX) {
            model.fail(joint->xml, "is one joint too many: an arm has at most " + std::to_string(ARM_JOINTS_MAX));
        }
        close_body();
        config.joints[config.joint_count++] = make_joint(model, *joint, placement);
        if (joint->xml->FirstChildElement("dynamics") != nullptr && !leaves_dynamics) {
            leaves_dynamics = true;
            arm.description += "; <dynamics> of its joints is left out";
        }
        arm.joint_names.push_back(joint->name);
        turning.push_back(joint);
        body = with_fixed(model, joint->child, chain);
        from_body = urdf_frame();
    }
    close_body();
    write_frame(from_body, config.tool);
    if (const arm_error error = arm_validate(&config); error.key != nullptr) {
        const std::string section = error.section;
        const std::string message = (*error.key != '\0' ? error.key + std::string(": ") : "") + error.message;
        if (section.rfind("joint", 0) == 0 && !turning.empty()) {
            model.fail(turning[static_cast<std::size_t>(error.joint)]->xml,
                       (section == "joint.link" ? "the link on it, with what is fixed to it: " : "") + message);
        }
        model.fail(section + (section == "base" ? " (link \"" + base + "\")" : "") + ": " + message);
    }
    return arm;
}

} // namespace berth
