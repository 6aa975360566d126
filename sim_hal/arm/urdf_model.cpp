#include "urdf_model.h"

#include <algorithm>
#include <cmath>
#include <Eigen/Geometry>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "../../firmware/arm/arm_config.h"
#include "../../hal/rig/keys.h"
#include "../../hal/rig/rig_file.h"
#include "../../hal/rig/toml_file.h"

namespace berth
{

namespace
{

constexpr double axis_length_min = 1e-9;
constexpr double excess_silent = 1e-6; /* of an inertia: rounding of what a CAD program prints */

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

/* The names of urdf_motion, in its order. */
constexpr const char *motion_words[] = {"fixed", "revolute", "continuous", "prismatic", "planar", "floating"};

std::string six_numbers(const Eigen::Matrix3d &i)
{
    std::ostringstream text;
    text.precision(6);
    text << "ixx " << i(0, 0) << ", ixy " << i(0, 1) << ", ixz " << i(0, 2) << ", iyy " << i(1, 1) << ", iyz "
         << i(1, 2) << ", izz " << i(2, 2);
    return text.str();
}

} // namespace

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
    if (links_.empty()) {
        fail(robot, "no <link>; one that is written in xacro has a name that ends in .xacro");
    }
    read_joints(robot);
    order_outward();
}

void urdf_model::read_joints(const urdf_element *robot)
{
    for (auto *xml = robot->FirstChildElement("joint"); xml != nullptr; xml = xml->NextSiblingElement("joint")) {
        const urdf_joint joint = read_joint(xml);
        if (!by_name_.emplace(joint.name, joints_.size()).second) {
            fail(xml, "there are two joints \"" + joint.name + "\"");
        }
        if (!by_child_.emplace(joint.child, joints_.size()).second) {
            fail(xml, "a second joint leads to link \"" + joint.child + "\"; an arm is an open chain");
        }
        joints_.push_back(joint);
    }
}

/* A joint comes after the one that its parent link hangs on, else in the order of the file. */
void urdf_model::order_outward()
{
    std::map<std::string, std::vector<std::size_t>> by_parent;
    for (std::size_t i = 0; i < joints_.size(); i++) {
        by_parent[joints_[i].parent].push_back(i);
    }
    std::vector<std::string> reached;
    for (const auto &[name, xml] : links_) {
        if (by_child_.count(name) == 0) {
            reached.push_back(name);
        }
    }
    std::vector<urdf_joint> ordered;
    for (std::size_t i = 0; i < reached.size(); i++) {
        for (const std::size_t joint : by_parent[reached[i]]) {
            ordered.push_back(joints_[joint]);
            reached.push_back(joints_[joint].child);
        }
    }
    if (ordered.size() < joints_.size()) {
        const std::set<std::string> outside(reached.begin(), reached.end());
        const auto in_circle = std::find_if(links_.begin(), links_.end(),
                                            [&](const auto &link) { return outside.count(link.first) == 0; });
        fail(in_circle->second,
             "its joints go round in a circle; a joint's parent must be nearer to the root than its child");
    }
    joints_ = std::move(ordered);
    for (std::size_t i = 0; i < joints_.size(); i++) {
        by_name_[joints_[i].name] = by_child_[joints_[i].child] = i;
    }
}

/* "file:line: <limit> of joint "elbow"": what has no name of its own is named after what it is in. */
std::string urdf_model::place(const urdf_element *at) const
{
    std::string what = std::string("<") + at->Name() + ">";
    if (const char *const name = at->Attribute("name")) {
        what += " " + in_quotes(name);
    } else {
        for (const tinyxml2::XMLNode *up = at->Parent(); up != nullptr && up->ToElement() != nullptr;
             up = up->Parent()) {
            const urdf_element *const owner = up->ToElement();
            if (owner->Attribute("name") != nullptr && std::string("robot") != owner->Name()) {
                what += std::string(" of ") + owner->Name() + " " + in_quotes(owner->Attribute("name"));
                break;
            }
        }
    }
    return origin_ + ":" + std::to_string(at->GetLineNum()) + ": " + what;
}

void urdf_model::fail(const urdf_element *at, const std::string &message) const
{
    throw input_error(place(at) + ": " + message);
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
                fail(xml, "is a second root beside \"" + found +
                              "\"; let a joint lead to it, or choose one of them with --base");
            }
            found = name;
        }
    }
    return found;
}

const urdf_joint *urdf_model::joint_to(const std::string &link) const
{
    const auto found = by_child_.find(link);
    return found == by_child_.end() ? nullptr : &joints_[found->second];
}

const urdf_joint *urdf_model::joint_named(const std::string &name) const
{
    const auto found = by_name_.find(name);
    return found == by_name_.end() ? nullptr : &joints_[found->second];
}

urdf_range urdf_model::range_of(const urdf_joint &joint) const
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const urdf_element *const limit = joint.xml->FirstChildElement("limit");
    const bool has_range = joint.motion == urdf_motion::revolute || joint.motion == urdf_motion::prismatic;
    if (limit == nullptr || !has_range) {
        return {-infinity, infinity, false};
    }
    const auto or_zero = [&](const char *key) {
        return limit->Attribute(key) == nullptr ? 0.0 : number(limit, key);
    };
    const urdf_range range = {or_zero("lower"), or_zero("upper"), true};
    const bool is_left_out = range.lower == 0.0 && range.upper == 0.0;
    return is_left_out ? urdf_range{-infinity, infinity, false} : range;
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
        fail(inertial, "needs <mass> and <inertia>");
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
        fail(mass, "must be 0 or more");
    }
    return origin_of(inertial) * body;
}

std::optional<std::string> urdf_model::doubt_about(const std::string &link) const
{
    const urdf_body body = body_of(link);
    if (body.mass_kg == 0.0 && !body.inertia_kg_m2.isZero(0.0)) {
        return "no mass, and yet moments of inertia; state both or neither";
    }
    const urdf_element *const xml = inertia_xml(link);
    Eigen::Matrix3d stated = Eigen::Matrix3d::Zero();
    if (xml != nullptr) {
        stated << number(xml, "ixx"), number(xml, "ixy"), number(xml, "ixz"), number(xml, "ixy"), number(xml, "iyy"),
            number(xml, "iyz"), number(xml, "ixz"), number(xml, "iyz"), number(xml, "izz");
    }
    const inertia_fault fault = inertia_fault_of(stated);
    if (!fault.is_negative && fault.excess <= excess_silent) {
        return std::nullopt;
    }
    std::ostringstream excess;
    excess.precision(2);
    excess << 100.0 * fault.excess << " %";
    return "no body has it: " +
           (fault.is_negative ? std::string("a principal moment is negative")
                              : "the largest principal moment is larger than the sum of the others" +
                                    (std::isfinite(fault.excess) ? ", by " + excess.str() : ", which is 0")) +
           "; is it in kg m2, about the centre of mass? The nearest that a body has: " + six_numbers(fault.nearest);
}

const urdf_element *urdf_model::inertia_xml(const std::string &link) const
{
    const urdf_element *const inertial = links_.at(link)->FirstChildElement("inertial");
    return inertial == nullptr ? nullptr : inertial->FirstChildElement("inertia");
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

std::optional<urdf_mimic> urdf_model::mimic_of(const urdf_element *xml) const
{
    const urdf_element *const mimic = xml->FirstChildElement("mimic");
    if (mimic == nullptr) {
        return std::nullopt;
    }
    const auto number_or = [&](const char *key, double otherwise) {
        return mimic->Attribute(key) == nullptr ? otherwise : number(mimic, key);
    };
    return urdf_mimic{attribute(mimic, "joint"), number_or("multiplier", 1.0), number_or("offset", 0.0)};
}

urdf_joint urdf_model::read_joint(const urdf_element *xml) const
{
    urdf_joint joint;
    joint.xml = xml;
    joint.name = attribute(xml, "name");
    const std::string type = attribute(xml, "type");
    const auto *const word = std::find(std::begin(motion_words), std::end(motion_words), type);
    if (word == std::end(motion_words)) {
        fail(xml,
             "is of type \"" + type + "\"; there are fixed, revolute, continuous, prismatic, planar and floating");
    }
    joint.motion = static_cast<urdf_motion>(word - std::begin(motion_words));
    joint.parent = attribute(child(xml, "parent"), "link");
    joint.child = attribute(child(xml, "child"), "link");
    for (const std::string &link : {joint.parent, joint.child}) {
        if (links_.count(link) == 0) {
            fail(xml, "there is no link \"" + link + "\"");
        }
    }
    joint.placement = origin_of(xml);
    if (joint.motion == urdf_motion::fixed || joint.motion == urdf_motion::floating) {
        return joint; /* whatever stands there of axis and mimic, they have none */
    }
    joint.mimic = mimic_of(xml);
    if (const urdf_element *const axis = xml->FirstChildElement("axis")) {
        joint.axis = vector(axis, "xyz");
        if (joint.axis.norm() < axis_length_min) {
            fail(axis, "xyz: has no direction");
        }
        joint.axis.normalize();
    }
    return joint;
}

} // namespace berth
