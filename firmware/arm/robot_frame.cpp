#include "robot_frame.h"

#include <cmath>

#include "../pi.h"

namespace berth
{

namespace
{

/* Of a vector this near to another direction there is too little left at right angles. */
constexpr double nearly_along = 0.9;
constexpr double no_turn = 1e-12;

/* From 0 to pi. sin(guess - angle) corrects a guess that is off by e to one that is off by e^3 / 6: from 0.58 at
 * most, four corrections leave less than the last bit. */
double angle_of(double sine, double cosine)
{
    double angle_rad = cosine >= 0.0 ? sine : pi - sine;
    for (int i = 0; i < 4; i++) {
        const sine_cosine guess = sine_and_cosine(angle_rad);
        angle_rad -= guess.sine * cosine - guess.cosine * sine;
    }
    return angle_rad;
}

} // namespace

space::vector rotation_vector(const space::rotation &rotation)
{
    const space::vector twice(rotation(2, 1) - rotation(1, 2), rotation(0, 2) - rotation(2, 0),
                              rotation(1, 0) - rotation(0, 1));
    const space::vector axis = 0.5 * twice; /* times the sine */
    const double sine = std::sqrt(axis.squaredNorm());
    const double cosine = 0.5 * (rotation.trace() - 1.0);
    const double length = std::sqrt(sine * sine + cosine * cosine);
    return sine > no_turn ? space::vector(axis * (angle_of(sine / length, cosine / length) / sine)) : axis;
}

space::rotation rotation_by(const space::vector &rotation_vector_rad)
{
    const double angle_rad = std::sqrt(rotation_vector_rad.squaredNorm());
    if (!(angle_rad > 0.0)) {
        return space::rotation::Identity();
    }
    const sine_cosine turn = sine_and_cosine(angle_rad);
    return space::turned(rotation_vector_rad / angle_rad, turn.sine, turn.cosine);
}

robot_frame<space> robot_frame<space>::with_x_along(const space::vector &x)
{
    const space::vector up = std::abs(x(2)) < nearly_along ? space::vector::UnitZ() : space::vector::UnitY();
    const space::vector rest = up - x * x.dot(up);
    const space::vector z = rest / std::sqrt(rest.squaredNorm());
    robot_frame frame;
    frame.axes << x, z.cross(x), z;
    frame.home_m.setZero();
    frame.home.setIdentity();
    return frame;
}

void robot_frame<space>::call(const space::vector &origin_m, const attitude &turned,
                              const double side[SIDE_AXIS_COUNT])
{
    const space::vector turn(side[SIDE_AXIS_RX], side[SIDE_AXIS_RY], side[SIDE_AXIS_RZ]);
    home_m = origin_m - axes.col(1) * side[SIDE_AXIS_Y] - axes.col(2) * side[SIDE_AXIS_Z];
    home = rotation_by(axes * turn).transpose() * turned;
}

void robot_frame<space>::show(const space::vector &origin_m, const attitude &turned,
                              double side[SIDE_AXIS_COUNT]) const
{
    const space::vector way = axes.transpose() * (origin_m - home_m);
    const space::vector turn = axes.transpose() * rotation_vector(turned * home.transpose());
    side[SIDE_AXIS_Y] = way(1);
    side[SIDE_AXIS_Z] = way(2);
    side[SIDE_AXIS_RX] = turn(0);
    side[SIDE_AXIS_RY] = turn(1);
    side[SIDE_AXIS_RZ] = turn(2);
}

wrench_of<space> robot_frame<space>::load(const double side[SIDE_AXIS_COUNT]) const
{
    const space::vector torque(side[SIDE_AXIS_RX], side[SIDE_AXIS_RY], side[SIDE_AXIS_RZ]);
    const space::vector force(0.0, side[SIDE_AXIS_Y], side[SIDE_AXIS_Z]);
    return {axes * torque, axes * force};
}

} // namespace berth
