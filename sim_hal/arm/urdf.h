/* Arms out of URDF, the robot description of ROS: a tree of links with inertia, on joints. */
#ifndef SIM_HAL_ARM_URDF_H
#define SIM_HAL_ARM_URDF_H

#include <optional>
#include <string>
#include <vector>

#include "../../hal/rig/arm_file.h"

namespace berth
{

/* A joint that does not move, at a value in rad or m; nothing: see resting_value(). */
struct urdf_hold {
    std::string joint;
    std::optional<double> value;
};

struct urdf_choice {
    std::string base; /* link; empty: the root, or the link behind a floating joint */
    std::string tool; /* link at the arm's end; empty: that of the longest movable chain */
    bool is_planar = false;
    std::vector<urdf_hold> holds = {};
};

struct urdf_arm : arm_description {
    std::vector<std::string> notes;    /* what was chosen and assumed, a sentence each; in short in `description` */
    std::vector<std::string> warnings; /* with file and line */
};

/* The chain of links from base to tool. Every other joint is held, and what hangs on it is part of the body that it
 * hangs on. A base without mass, or a link "world" without, is held: an arm on the ground. URDF knows nothing of
 * motors: where it says nothing, joints get `stand_in_joint`. `origin` names the text in messages. Throws
 * input_error with file and line. */
urdf_arm arm_from_urdf(const std::string &text, const std::string &origin, const urdf_choice &choice);

/* The URDF that the program `xacro` makes of a file. Throws input_error where it is not installed, or fails. */
std::string expand_xacro(const std::string &path);

} // namespace berth

#endif
