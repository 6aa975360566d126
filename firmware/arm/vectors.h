/* The algebra of rigid-body motion, once for the plane and once for space, behind the same names: the dynamics in
 * dynamics.h are written over it and know of no dimension.
 *
 * A motion is (angular, linear velocity of the frame's origin), a wrench (torque about that origin, force), both in
 * the axes of the body's own frame: Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 2. */
#ifndef FIRMWARE_ARM_VECTORS_H
#define FIRMWARE_ARM_VECTORS_H

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "sine.h"

namespace berth
{

/* x and y, turning about z. */
struct plane {
    static constexpr int dimension = 2;
    static constexpr int turns = 1;         /* ways to turn */
    static constexpr int attitude_size = 1; /* the angle, rad: it does not wrap */

    using vector = Eigen::Matrix<double, 2, 1>;
    using angular = Eigen::Matrix<double, 1, 1>;
    using rotation = Eigen::Matrix<double, 2, 2>;
    using attitude = Eigen::Matrix<double, 1, 1>;
    using lever_matrix = Eigen::Matrix<double, 2, 1>;

    /* w x r = lever(r) w, and r x f = lever(r)^T f. */
    static lever_matrix lever(const vector &r) { return {-r(1), r(0)}; }
    static angular cross(const angular &, const angular &) { return angular::Zero(); }
    static angular along_axis(const Eigen::Vector3d &axis) { return angular(axis(2)); }

    /* Axes of a frame that is turned by the angle with this sine and cosine, in the axes it was turned from. */
    static rotation turned(const angular &axis, double sine, double cosine)
    {
        rotation axes;
        axes << cosine, -axis(0) * sine, axis(0) * sine, cosine;
        return axes;
    }

    static attitude no_turn() { return attitude::Zero(); }
    static rotation axes_of(const attitude &attitude)
    {
        const sine_cosine turn = sine_and_cosine(attitude(0));
        return turned(angular(1.0), turn.sine, turn.cosine);
    }
    static attitude attitude_rate(const attitude &, const angular &rate) { return rate; }
    static attitude turned_by(const attitude &from, const angular &turn_rad) { return from + turn_rad; }
    static attitude normalised(const attitude &attitude) { return attitude; }
    /* Turn that leads from one attitude to the other, for small ones in rad, in the axes of the first. */
    static angular turn_between(const attitude &from, const attitude &to) { return to - from; }
};

struct space {
    static constexpr int dimension = 3;
    static constexpr int turns = 3;
    static constexpr int attitude_size = 4; /* unit quaternion w, x, y, z */

    using vector = Eigen::Matrix<double, 3, 1>;
    using angular = Eigen::Matrix<double, 3, 1>;
    using rotation = Eigen::Matrix<double, 3, 3>;
    using attitude = Eigen::Matrix<double, 4, 1>;
    using lever_matrix = Eigen::Matrix<double, 3, 3>;

    static lever_matrix lever(const vector &r)
    {
        lever_matrix result;
        result << 0.0, r(2), -r(1), -r(2), 0.0, r(0), r(1), -r(0), 0.0;
        return result;
    }
    static angular cross(const angular &a, const angular &b) { return a.cross(b); }
    static angular along_axis(const Eigen::Vector3d &axis) { return axis; }

    static rotation turned(const angular &axis, double sine, double cosine)
    {
        const lever_matrix hat = -lever(axis); /* hat r = axis x r */
        return rotation::Identity() + sine * hat + (1.0 - cosine) * (hat * hat);
    }

    static attitude no_turn() { return {1.0, 0.0, 0.0, 0.0}; }
    static rotation axes_of(const attitude &attitude)
    {
        return Eigen::Quaterniond(attitude(0), attitude(1), attitude(2), attitude(3)).toRotationMatrix();
    }
    /* q (x) (0, w) / 2: `rate` is in the body's axes. */
    static attitude attitude_rate(const attitude &q, const angular &rate) { return 0.5 * product(q, 0.0, rate); }
    /* q (x) (1, turn / 2), normalised: a turn of 2 atan(|turn| / 2) about it, exact to the second order. */
    static attitude turned_by(const attitude &from, const angular &turn_rad)
    {
        return normalised(product(from, 1.0, 0.5 * turn_rad));
    }
    static attitude normalised(const attitude &attitude) { return attitude / std::sqrt(attitude.squaredNorm()); }
    static angular turn_between(const attitude &from, const attitude &to)
    {
        const attitude turn = product(conjugate(from), to(0), to.tail<3>());
        return (turn(0) < 0.0 ? -2.0 : 2.0) * turn.tail<3>();
    }

  private:
    static attitude conjugate(const attitude &q) { return {q(0), -q(1), -q(2), -q(3)}; }
    static attitude product(const attitude &q, double scalar, const angular &vector)
    {
        attitude result;
        result(0) = q(0) * scalar - q.tail<3>().dot(vector);
        result.tail<3>() = q(0) * vector + scalar * q.tail<3>() + Eigen::Vector3d(q.tail<3>()).cross(vector);
        return result;
    }
};

template <class Space>
struct motion_of {
    static constexpr int size = Space::turns + Space::dimension;

    typename Space::angular angular;
    typename Space::vector linear;

    static motion_of zero() { return {Space::angular::Zero(), Space::vector::Zero()}; }
    motion_of operator+(const motion_of &other) const { return {angular + other.angular, linear + other.linear}; }
    motion_of operator*(double factor) const { return {angular * factor, linear * factor}; }
};

template <class Space>
struct wrench_of {
    typename Space::angular torque;
    typename Space::vector force;

    static wrench_of zero() { return {Space::angular::Zero(), Space::vector::Zero()}; }
    wrench_of operator+(const wrench_of &other) const { return {torque + other.torque, force + other.force}; }
    wrench_of operator-(const wrench_of &other) const { return {torque - other.torque, force - other.force}; }
    wrench_of operator*(double factor) const { return {torque * factor, force * factor}; }
};

template <class Space>
double dot(const motion_of<Space> &motion, const wrench_of<Space> &wrench)
{
    return motion.angular.dot(wrench.torque) + motion.linear.dot(wrench.force);
}

/* Change of motion `b` that is carried along by motion `a`. */
template <class Space>
motion_of<Space> cross(const motion_of<Space> &a, const motion_of<Space> &b)
{
    return {Space::cross(a.angular, b.angular),
            Space::lever(b.linear) * a.angular - Space::lever(a.linear) * b.angular};
}

/* The same of a wrench or a momentum. */
template <class Space>
wrench_of<Space> cross(const motion_of<Space> &a, const wrench_of<Space> &b)
{
    return {Space::cross(a.angular, b.torque) + Space::lever(a.linear).transpose() * b.force,
            Space::lever(b.force) * a.angular};
}

/* Inertia that maps a motion to a momentum or, articulated, an acceleration to a wrench: symmetric, in blocks. */
template <class Space>
struct inertia_of {
    Eigen::Matrix<double, Space::turns, Space::turns> turning;
    Eigen::Matrix<double, Space::turns, Space::dimension> coupling;
    Eigen::Matrix<double, Space::dimension, Space::dimension> moving;

    static inertia_of zero()
    {
        inertia_of none;
        none.turning.setZero();
        none.coupling.setZero();
        none.moving.setZero();
        return none;
    }

    /* Of a rigid body, about the frame's origin. `about_centre`: kg m2, in the frame's axes. */
    static inertia_of rigid(double mass_kg, const typename Space::vector &centre_m,
                            const Eigen::Matrix<double, Space::turns, Space::turns> &about_centre)
    {
        const typename Space::lever_matrix lever = Space::lever(centre_m);
        inertia_of body;
        body.turning = about_centre + mass_kg * (lever.transpose() * lever);
        body.coupling = mass_kg * lever.transpose();
        body.moving.setIdentity();
        body.moving *= mass_kg;
        return body;
    }

    wrench_of<Space> operator*(const motion_of<Space> &motion) const
    {
        return {turning * motion.angular + coupling * motion.linear,
                coupling.transpose() * motion.angular + moving * motion.linear};
    }

    inertia_of &operator+=(const inertia_of &other)
    {
        turning += other.turning;
        coupling += other.coupling;
        moving += other.moving;
        return *this;
    }

    /* this - u u^T / scale */
    void remove(const wrench_of<Space> &u, double scale)
    {
        const wrench_of<Space> scaled = u * (1.0 / scale);
        turning -= u.torque * scaled.torque.transpose();
        coupling -= u.torque * scaled.force.transpose();
        moving -= u.force * scaled.force.transpose();
    }

    Eigen::Matrix<double, motion_of<Space>::size, motion_of<Space>::size> matrix() const
    {
        Eigen::Matrix<double, motion_of<Space>::size, motion_of<Space>::size> all;
        all << turning, coupling, coupling.transpose(), moving;
        return all;
    }
};

/* A child frame as its parent sees it: origin and axes (columns). */
template <class Space>
struct placement_of {
    typename Space::vector origin_m;
    typename Space::rotation axes;

    motion_of<Space> to_child(const motion_of<Space> &motion) const
    {
        return {turn_back(motion.angular),
                axes.transpose() * (motion.linear + Space::lever(origin_m) * motion.angular)};
    }
    wrench_of<Space> to_parent(const wrench_of<Space> &wrench) const
    {
        const typename Space::vector force = axes * wrench.force;
        return {turn(wrench.torque) + Space::lever(origin_m).transpose() * force, force};
    }
    inertia_of<Space> to_parent(const inertia_of<Space> &inertia) const
    {
        const typename Space::lever_matrix lever = Space::lever(origin_m);
        inertia_of<Space> result;
        result.moving = axes * inertia.moving * axes.transpose();
        const auto coupling = turn_rows(inertia.coupling * axes.transpose());
        const auto lifted = (result.moving * lever).eval();
        result.coupling = coupling + lifted.transpose();
        const auto mixed = (coupling * lever).eval();
        result.turning = turn_both(inertia.turning) + mixed + mixed.transpose() + lever.transpose() * lifted;
        return result;
    }

    placement_of operator*(const placement_of &child) const
    {
        return {origin_m + axes * child.origin_m, axes * child.axes};
    }

    /* What turns is a vector in space and a number in the plane. */
    typename Space::angular turn(const typename Space::angular &angular) const
    {
        if constexpr (Space::turns == 1) {
            return angular;
        } else {
            return axes * angular;
        }
    }
    typename Space::angular turn_back(const typename Space::angular &angular) const
    {
        if constexpr (Space::turns == 1) {
            return angular;
        } else {
            return axes.transpose() * angular;
        }
    }

  private:
    template <class Rows>
    Eigen::Matrix<double, Space::turns, Space::dimension> turn_rows(const Rows &rows) const
    {
        if constexpr (Space::turns == 1) {
            return rows;
        } else {
            return axes * rows;
        }
    }
    Eigen::Matrix<double, Space::turns, Space::turns>
    turn_both(const Eigen::Matrix<double, Space::turns, Space::turns> &turning) const
    {
        if constexpr (Space::turns == 1) {
            return turning;
        } else {
            return axes * turning * axes.transpose();
        }
    }
};

} // namespace berth

#endif
