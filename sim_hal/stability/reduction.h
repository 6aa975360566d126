/* From a whole arm, or a beam, to one degree of freedom, and what that leaves out. */
#ifndef SIM_HAL_STABILITY_REDUCTION_H
#define SIM_HAL_STABILITY_REDUCTION_H

#include <complex>
#include <optional>

#include "../../hal/rig/beam.h"
#include "../arm/free_swing.h"
#include "arm_loop.h"

namespace berth
{

/* The robot's dead time, from the shortest on, up to which the loop is stable; 0: it is unstable at the shortest;
 * nothing: as far as was looked. Further axes have theirs as much longer or shorter. */
struct dead_time_limits {
    std::optional<double> reduced_ms;
    std::optional<double> full_ms;
    double looked_from_ms;
    double looked_to_ms;
};

struct reduction {
    std::vector<arm_mode> modes; /* along the direction */
    arm_mode reduced; /* the dominant one of them, dominant_mode: the manipulator of one degree of freedom */
    /* With the rig's object fixed to it, without dead time. */
    swing coupled_reduced;
    std::vector<coupled_mode> visible;   /* of the full arm */
    std::optional<coupled_mode> nearest; /* of those; nothing: none is near */
    std::optional<swing> coupled_full;   /* its swing */
    /* In the rig's loop. */
    arm_loop_growth loop_reduced;
    arm_loop_growth loop_full;
    /* By how much stiffer the object may be until the loop is unstable; nothing: not up to 1e4 times. */
    std::optional<double> object_limit_reduced;
    std::optional<double> object_limit_full;
    dead_time_limits dead_time;
};

/* A beam reduced to its first mode, at the manipulator of one degree of freedom. */
struct object_reduction {
    std::vector<beam_mode> modes; /* the first is the object of one degree of freedom */
    double compliance_share;      /* what the first mode has of the compliance of all */
    /* With the manipulator fixed to it, without dead time: the first that swings. */
    swing coupled_reduced;
    swing coupled_full;
    /* In the rig's loop. */
    arm_loop_growth loop_reduced;
    arm_loop_growth loop_full;
    /* As of an arm. */
    std::optional<double> object_limit_reduced;
    std::optional<double> object_limit_full;
    dead_time_limits dead_time;
};

/* Of a rig whose object is a beam. Throws input_error for a rig without one-period map. */
object_reduction reduce_object(const rig &rig);

/* Throws input_error for a rig without one-period map, or a pose at which no spring of the arm moves its tool along
 * the direction. */
reduction reduce(const rig &rig, const arm_config &arm, const reduction_choice &choice);

} // namespace berth

#endif
