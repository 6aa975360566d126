#include "urdf_body.h"

#include <algorithm>

#include "../solver/decompositions.h"

namespace berth
{

namespace
{

constexpr double negative_allowed = 1e-9; /* of the largest moment: what eigenvalues are computed to */

/* m (r^2 1 - r r^T): what a mass at `arm_m` adds to the inertia about another point. */
Eigen::Matrix3d of_point(double mass_kg, const Eigen::Vector3d &arm_m)
{
    return mass_kg * (arm_m.squaredNorm() * Eigen::Matrix3d::Identity() - arm_m * arm_m.transpose());
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

inertia_fault inertia_fault_of(const Eigen::Matrix3d &inertia_kg_m2)
{
    const eigenpairs principal = symmetric_eigenpairs(inertia_kg_m2);
    const Eigen::Vector3d moments = principal.values; /* ascending */
    const double others = moments(0) + moments(1);
    const double missing = std::max(0.0, moments(2) - others);
    /* The nearest point on the plane where the largest is the sum of the others: its normal is (1, 1, -1). */
    const Eigen::Vector3d nearest = (moments + missing / 3.0 * Eigen::Vector3d(1.0, 1.0, -1.0)).cwiseMax(0.0);
    const Eigen::Matrix3d axes = principal.vectors;
    return {moments(0) < -negative_allowed * moments(2), missing > 0.0 ? missing / std::max(0.0, others) : 0.0,
            axes * nearest.asDiagonal() * axes.transpose()};
}

} // namespace berth
