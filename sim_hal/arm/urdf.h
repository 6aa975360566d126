/* Arms out of URDF, the robot description of ROS: links with inertia and revolute joints. */
#ifndef SIM_HAL_ARM_URDF_H
#define SIM_HAL_ARM_URDF_H

#include <string>

#include "../../hal/rig/arm_file.h"

namespace berth
{

struct urdf_choice {
    std::string base; /* link; empty: the root */
    std::string tool; /* link at the arm's end; empty: the only leaf */
    bool is_planar = false;
};

/* The chain of links from base to tool. Fixed joints join two links to one body; what hangs on a link of the chain
 * outside it must hang by fixed joints. URDF knows nothing of motors: where it says nothing, joints get
 * `stand_in_joint`. `origin` names the text in messages. Throws input_error with file and line. */
arm_description arm_from_urdf(const std::string &text, const std::string &origin, const urdf_choice &choice);

} // namespace berth

#endif
