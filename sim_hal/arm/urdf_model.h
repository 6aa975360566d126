/* A URDF file as links and joints, every fault with its line. */
#ifndef SIM_HAL_ARM_URDF_MODEL_H
#define SIM_HAL_ARM_URDF_MODEL_H

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <tinyxml2.h>
#include <vector>

#include "urdf_body.h"

namespace berth
{

using urdf_element = tinyxml2::XMLElement;

enum class urdf_motion { fixed, revolute, continuous, prismatic, planar, floating };

/* Of a joint that follows another: its value is multiplier * value of `joint` + offset. */
struct urdf_mimic {
    std::string joint;
    double multiplier = 1.0;
    double offset = 0.0;
};

/* rad or m; the whole line where the file states none, or 0 to 0 as where both are left out. */
struct urdf_range {
    double lower;
    double upper;
    bool is_stated;
};

/* A joint with the link that hangs on it. */
struct urdf_joint {
    std::string name;
    urdf_motion motion = urdf_motion::fixed;
    std::string parent;
    std::string child;
    urdf_frame placement;                            /* at the value 0 */
    Eigen::Vector3d axis = Eigen::Vector3d::UnitX(); /* of a planar joint: the plane's normal */
    std::optional<urdf_mimic> mimic;
    const urdf_element *xml = nullptr;
};

class urdf_model
{
  public:
    /* Throws input_error. */
    urdf_model(const std::string &text, std::string origin);

    const std::string &name() const { return name_; }
    /* A joint comes after the one that its parent link hangs on. */
    const std::vector<urdf_joint> &joints() const { return joints_; }
    bool has_link(const std::string &name) const { return links_.count(name) > 0; }
    std::size_t link_count() const { return links_.size(); }

    /* The link that no joint leads to. */
    std::string root() const;
    /* nullptr: none. */
    const urdf_joint *joint_to(const std::string &link) const;
    /* nullptr: none. */
    const urdf_joint *joint_named(const std::string &name) const;
    /* From <limit>; fails where a number is none. */
    urdf_range range_of(const urdf_joint &joint) const;
    /* Mass and inertia of a link by itself, in its frame, as the file states them: see doubt_about(). */
    urdf_body body_of(const std::string &link) const;
    /* What no body has: moments without mass, or such that a principal one is negative or larger than the sum of the
     * others. A sentence with the nearest that a body has; nothing: all is well. */
    std::optional<std::string> doubt_about(const std::string &link) const;
    /* Where a doubt about it is. */
    const urdf_element *inertia_xml(const std::string &link) const;

    /* "file:line: <element> "name"" */
    std::string place(const urdf_element *at) const;
    [[noreturn]] void fail(const urdf_element *at, const std::string &message) const;
    [[noreturn]] void fail(const std::string &message) const;
    /* Fails where it is missing, or none. */
    double number(const urdf_element *at, const char *key) const;

  private:
    std::string attribute(const urdf_element *at, const char *key) const;
    Eigen::Vector3d vector(const urdf_element *at, const char *key) const;
    urdf_frame origin_of(const urdf_element *at) const;
    const urdf_element *child(const urdf_element *at, const char *name) const;
    urdf_joint read_joint(const urdf_element *xml) const;
    std::optional<urdf_mimic> mimic_of(const urdf_element *xml) const;
    void read_joints(const urdf_element *robot);
    void order_outward();

    tinyxml2::XMLDocument document_;
    std::string origin_;
    std::string name_;
    std::map<std::string, const urdf_element *> links_;
    std::vector<urdf_joint> joints_;
    std::map<std::string, std::size_t> by_child_; /* places in joints_ */
    std::map<std::string, std::size_t> by_name_;
};

} // namespace berth

#endif
