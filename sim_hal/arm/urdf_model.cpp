#include "urdf_model.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <sstream>

#include "../../firmware/arm/arm_config.h"
#include "../../hal/rig/keys.h"
#include "../../hal/rig/rig_file.h"
#include "../../hal/rig/toml_file.h"

namespace berth
{

namespace
{

/* m (r^2 1 - r r^T): what a mass at `arm_m` adds to the inertia about another point. */
Eigen::Matrix3d of_point(double mass_kg, const Eigen::Vector3d &arm_m)
{
    return mass_kg * (arm_m.squaredNorm() * Eigen::Matrix3d::Identity() - arm_m * arm_m.transpose());
}

/* What is read goes into arm files and JSON. */
void refuse_other_encodings(const std::string &text, const std::string &origin)
{
    std::istringstream lines(text);
    std::string line;
    for (int number = 1; std::getline(lines, line); number++) {
        try {
            (void)nlohmann::json(line).dump();
        } catch (const nlohmann::json::type_error &) {
            throw input_error(origin + ":" + std::to_string(number) + ": is not UTF-8; save the file in that");
        }
    }
}

} // namespace

urdf_body joined(const urdf_body &a, const urdf_body &b)
{
    urdf_body both;
    both.mass_kg = a.mass_kg + b.mass_kg;
    if (both.mass_kg > 0.0) {
        both.centre_m = (a.mass_kg * a.centre_m + b.mass_kg * b.centre_m) / both.mass_kg;
    }
    both.inertia_kg_m2 = a.inertia_kg_m2 + of_point(a.mass_kg, a.centre_m - both.centre_m) + b.inertia_kg_m2 +
                         of_point(b.mass_kg, b.centre_m - both.centre_m);
    return both;
}

urdf_frame urdf_frame::operator*(const urdf_frame &child) const
{
    return {origin_m + axes * child.origin_m, axes * child.axes};
}

urdf_body urdf_frame::operator*(const urdf_body &body) const
{
    return {body.mass_kg, origin_m + axes * body.centre_m, axes * body.inertia_kg_m2 * axes.transpose()};
}

urdf_model::urdf_model(const std::string &text, std::string origin) : origin_(std::move(origin))
{
    refuse_other_encodings(text, origin_);
    if (document_.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS) {
        throw input_error(origin_ + ":" + std::to_string(std::max(1, document_.ErrorLineNum())) +
                          ": not well-formed XML (" + tinyxml2::XMLDocument::ErrorIDToName(document_.ErrorID()) +
                          ")");
    }
    const urdf_element *const robot = document_.FirstChildElement("robot");
    if (robot == nullptr) {
        throw input_error(origin_ + ":1: no <robot>; is it a URDF file?");
    }
    name_ = robot->Attribute("name") != nullptr ? robot->Attribute("name") : "";
    if (!name_.empty() && !is_file_name(name_)) {
        fail(robot, "its name names files: it must have at most 100 bytes, no \"/\" and no control characters, and "
                    "must not start with \".\"");
    }
    for (auto *link = robot->FirstChildElement("link"); link != nullptr; link = link->NextSiblingElement("link")) {
        const std::string name = attribute(link, "name");
        if (!links_.emplace(name, link).second) {
            fail(link, "there are two links \"" + name + "\"");
        }
    }
    for (auto *xml = robot->FirstChildElement("joint"); xml != nullptr; xml = xml->NextSiblingElement("joint")) {
        read_joint(xml);
    }
    if (links_.empty()) {
        fail(robot, "no <link>");
    }
    refuse_circles();
}

void urdf_model::fail(const urdf_element *at, const std::string &message) const
{
    std::string what = std::string("<") + at->Name() + ">";
    if (const char *const name = at->Attribute("name")) {
        what += " " + quoted(name);
    }
    throw input_error(origin_ + ":" + std::to_string(at->GetLineNum()) + ": " + what + ": " + message);
}

void urdf_model::fail(const std::string &message) const
{
    throw input_error(origin_ + ": " + message);
}

std::string urdf_model::root() const
{
    std::string found;
    for (const auto &[name, xml] : links_) {
        if (joint_to(name) == nullptr) {
            if (!found.empty()) {
                fail(xml, "is a second root beside \"" + found + "\"; a joint must lead to it");
            }
            found = name;
        }
    }
    if (found.empty()) {
        fail("no link is the root: its joints go round in a circle");
    }
    return found;
}

void urdf_model::refuse_circles() const
{
    for (const auto &[name, xml] : links_) {
        const urdf_joint *joint = joint_to(name);
        for (std::size_t up = 0; joint != nullptr; up++) {
            if (up > joints_.size()) {
                fail(xml,
                     "its joints go round in a circle; a joint's parent must be nearer to the root than its child");
            }
            joint = joint_to(joint->parent);
        }
    }
}

const urdf_joint *urdf_model::joint_to(const std::string &link) const
{
    const auto found =
        std::find_if(joints_.begin(), joints_.end(), [&](const urdf_joint &joint) { return joint.child == link; });
    return found == joints_.end() ? nullptr : &*found;
}

urdf_body urdf_model::body_of(const std::string &name) const
{
    const urdf_element *const inertial = links_.at(name)->FirstChildElement("inertial");
    if (inertial == nullptr) {
        return {};
    }
    const urdf_element *const mass = inertial->FirstChildElement("mass");
    const urdf_element *const inertia = inertial->FirstChildElement("inertia");
    if (mass == nullptr || inertia == nullptr) {
        fail(inertial, "of link \"" + name + "\" needs <mass> and <inertia>");
    }
    urdf_body body;
    body.mass_kg = number(mass, "value");
    /* All are read before any is written: a matrix that is left half written ends the program. */
    const double xx = number(inertia, "ixx");
    const double xy = number(inertia, "ixy");
    const double xz = number(inertia, "ixz");
    const double yy = number(inertia, "iyy");
    const double yz = number(inertia, "iyz");
    const double zz = number(inertia, "izz");
    body.inertia_kg_m2 << xx, xy, xz, xy, yy, yz, xz, yz, zz;
    if (!(body.mass_kg >= 0.0)) {
        fail(mass, "of link \"" + name + "\": must be 0 or more");
    }
    if (body.mass_kg == 0.0 && body.inertia_kg_m2.cwiseAbs().maxCoeff() > 0.0) {
        fail(mass, "of link \"" + name + "\": no mass, and yet moments of inertia; state both or neither");
    }
    const Eigen::Vector3d principal = body.inertia_kg_m2.selfadjointView<Eigen::Lower>().eigenvalues();
    if (principal(0) < -1e-9 * principal(2) || principal(2) > (principal(0) + principal(1)) * (1.0 + 1e-6)) {
        fail(inertia, "of link \"" + name +
                          "\": no body has it: no principal moment may be negative or larger than the sum of the "
                          "others; is it in kg m2, about the centre of mass?");
    }
    return origin_of(inertial) * body;
}

double urdf_model::number(const urdf_element *at, const char *key) const
{
    /* tinyxml2 reads as far as it understands: of "1,5" it makes 1. */
    std::istringstream text(attribute(at, key));
    double value = 0.0;
    std::string rest;
    if (!(text >> value) || text >> rest || !std::isfinite(value)) {
        fail(at, std::string(key) + ": must be a number (is \"" + attribute(at, key) + "\")");
    }
    return value;
}

std::string urdf_model::attribute(const urdf_element *at, const char *key) const
{
    const char *const text = at->Attribute(key);
    if (text == nullptr || *text == '\0') {
        fail(at, std::string(key) + ": is missing");
    }
    return text;
}

Eigen::Vector3d urdf_model::vector(const urdf_element *at, const char *key) const
{
    std::istringstream text(attribute(at, key));
    Eigen::Vector3d value;
    std::string rest;
    if (!(text >> value(0) >> value(1) >> value(2)) || text >> rest || !value.allFinite()) {
        fail(at, std::string(key) + ": must be three numbers");
    }
    return value;
}

urdf_frame urdf_model::origin_of(const urdf_element *at) const
{
    urdf_frame result;
    if (const urdf_element *const origin = at->FirstChildElement("origin")) {
        if (origin->Attribute("xyz") != nullptr) {
            result.origin_m = vector(origin, "xyz");
        }
        if (origin->Attribute("rpy") != nullptr) {
            const Eigen::Vector3d rpy = vector(origin, "rpy");
            if (!(rpy.cwiseAbs().maxCoeff() <= ARM_ANGLE_MAX_rad)) {
                fail(origin, "rpy: must be within 1e6 rad; leave whole turns out");
            }
            result.axes = (Eigen::AngleAxisd(rpy(2), Eigen::Vector3d::UnitZ()) *
                           Eigen::AngleAxisd(rpy(1), Eigen::Vector3d::UnitY()) *
                           Eigen::AngleAxisd(rpy(0), Eigen::Vector3d::UnitX()))
                              .toRotationMatrix();
        }
    }
    return result;
}

const urdf_element *urdf_model::child(const urdf_element *at, const char *name) const
{
    const urdf_element *const found = at->FirstChildElement(name);
    if (found == nullptr) {
        fail(at, std::string("has no <") + name + ">");
    }
    return found;
}

void urdf_model::read_joint(const urdf_element *xml)
{
    urdf_joint joint;
    joint.xml = xml;
    joint.name = attribute(xml, "name");
    if (std::any_of(joints_.begin(), joints_.end(),
                    [&](const urdf_joint &other) { return other.name == joint.name; })) {
        fail(xml, "there are two joints \"" + joint.name + "\"");
    }
    joint.type = attribute(xml, "type");
    joint.parent = attribute(child(xml, "parent"), "link");
    joint.child = attribute(child(xml, "child"), "link");
    for (const std::string &link : {joint.parent, joint.child}) {
        if (links_.count(link) == 0) {
            fail(xml, "there is no link \"" + link + "\"");
        }
    }
    if (joint_to(joint.child) != nullptr) {
        fail(xml, "a second joint leads to link \"" + joint.child + "\"; an arm is an open chain");
    }
    joint.placement = origin_of(xml);
    if (const urdf_element *const axis = xml->FirstChildElement("axis")) {
        joint.axis = vector(axis, "xyz");
        if (joint.axis.norm() < 1e-9) {
            fail(axis, "xyz: has no direction");
        }
        joint.axis.normalize();
    }
    joints_.push_back(joint);
}

} // namespace berth
