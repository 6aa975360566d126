/* A URDF file as links and joints, every fault with its line. */
#ifndef SIM_HAL_ARM_URDF_MODEL_H
#define SIM_HAL_ARM_URDF_MODEL_H

#include <Eigen/Core>
#include <map>
#include <string>
#include <tinyxml2.h>
#include <vector>

namespace berth
{

using urdf_element = tinyxml2::XMLElement;

/* A rigid body in some frame: inertia about its centre. */
struct urdf_body {
    double mass_kg = 0.0;
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
    Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();
};

/* Two bodies in one frame as one. */
urdf_body joined(const urdf_body &a, const urdf_body &b);

struct urdf_frame {
    Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();

    urdf_frame operator*(const urdf_frame &child) const;
    urdf_body operator*(const urdf_body &body) const;
};

/* A joint with the link that hangs on it. */
struct urdf_joint {
    std::string name;
    std::string type;
    std::string parent;
    std::string child;
    urdf_frame placement;
    Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
    const urdf_element *xml = nullptr;
};

class urdf_model
{
  public:
    /* Throws input_error. */
    urdf_model(const std::string &text, std::string origin);

    const std::string &name() const { return name_; }
    const std::vector<urdf_joint> &joints() const { return joints_; }
    bool has_link(const std::string &name) const { return links_.count(name) > 0; }

    /* The link that no joint leads to. */
    std::string root() const;
    /* nullptr: none. */
    const urdf_joint *joint_to(const std::string &link) const;
    /* Mass and inertia of a link by itself, in its frame. */
    urdf_body body_of(const std::string &link) const;

    [[noreturn]] void fail(const urdf_element *at, const std::string &message) const;
    [[noreturn]] void fail(const std::string &message) const;
    /* Fails where it is missing, or none. */
    double number(const urdf_element *at, const char *key) const;

  private:
    std::string attribute(const urdf_element *at, const char *key) const;
    Eigen::Vector3d vector(const urdf_element *at, const char *key) const;
    urdf_frame origin_of(const urdf_element *at) const;
    const urdf_element *child(const urdf_element *at, const char *name) const;
    void read_joint(const urdf_element *xml);
    void refuse_circles() const;

    tinyxml2::XMLDocument document_;
    std::string origin_;
    std::string name_;
    std::map<std::string, const urdf_element *> links_;
    std::vector<urdf_joint> joints_;
};

} // namespace berth

#endif
