/* Rigid bodies and frames of a URDF file. */
#ifndef SIM_HAL_ARM_URDF_BODY_H
#define SIM_HAL_ARM_URDF_BODY_H

#include <Eigen/Core>

namespace berth
{

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

/* How far a symmetric matrix is from the inertia of a body about its centre: no principal moment may be negative or
 * larger than the sum of the others. */
struct inertia_fault {
    bool is_negative; /* a principal moment is */
    double excess;    /* largest principal moment / sum of the others - 1, infinite where they are 0; 0: no fault */
    Eigen::Matrix3d nearest; /* that a body can have, by the Frobenius norm */
};

inertia_fault inertia_fault_of(const Eigen::Matrix3d &inertia_kg_m2);

} // namespace berth

#endif
