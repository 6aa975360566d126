/* Pinocchio's URDF reader includes this header of urdfdom, which none of the Python packages brings. Of what it says,
 * the two names alone are needed: the library knows the rest. */
#ifndef PINOCCHIO_LACKS_URDF_MODEL_H
#define PINOCCHIO_LACKS_URDF_MODEL_H

namespace urdf
{
class ModelInterface;
class Pose;
} // namespace urdf

#endif
