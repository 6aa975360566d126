/* The tool's pose as the robot's further axes show it (enum side_axis in config.h), and what is measured there as a
 * load on the tool. */
#ifndef FIRMWARE_ARM_ROBOT_FRAME_H
#define FIRMWARE_ARM_ROBOT_FRAME_H

#include "../config.h"
#include "vectors.h"

namespace berth
{

template <class Space>
struct robot_frame;

template <>
struct robot_frame<plane> {
    using attitude = double; /* of the tool, rad: it does not wrap */

    plane::vector y;
    double y_home_m = 0.0;
    double turn_home_rad = 0.0;

    static robot_frame with_x_along(const plane::vector &x) { return {{-x(1), x(0)}, 0.0, 0.0}; }

    /* From now on this pose counts as `side`. */
    void call(const plane::vector &origin_m, attitude turn_rad, const double side[SIDE_AXIS_COUNT])
    {
        y_home_m = y.dot(origin_m) - side[SIDE_AXIS_Y];
        turn_home_rad = turn_rad - side[SIDE_AXIS_RZ];
    }

    void show(const plane::vector &origin_m, attitude turn_rad, double side[SIDE_AXIS_COUNT]) const
    {
        side[SIDE_AXIS_Y] = y.dot(origin_m) - y_home_m;
        side[SIDE_AXIS_RZ] = turn_rad - turn_home_rad;
    }

    /* On the tool, about its origin, in the world's axes. */
    wrench_of<plane> load(const double side[SIDE_AXIS_COUNT]) const
    {
        return {plane::angular(side[SIDE_AXIS_RZ]), y * side[SIDE_AXIS_Y]};
    }
};

template <>
struct robot_frame<space> {
    using attitude = space::rotation; /* the tool's axes in the world, as columns */

    space::rotation axes; /* x, y and z of the robot in the world, as columns */
    space::vector home_m;
    attitude home;

    static robot_frame with_x_along(const space::vector &x);

    /* From now on this pose counts as `side`. */
    void call(const space::vector &origin_m, const attitude &turned, const double side[SIDE_AXIS_COUNT]);

    void show(const space::vector &origin_m, const attitude &turned, double side[SIDE_AXIS_COUNT]) const;

    /* On the tool, about its origin, in the world's axes. */
    wrench_of<space> load(const double side[SIDE_AXIS_COUNT]) const;
};

/* Axis times angle of a rotation, its angle from 0 to pi rad, and back. */
space::vector rotation_vector(const space::rotation &rotation);
space::rotation rotation_by(const space::vector &rotation_vector_rad);

} // namespace berth

#endif
