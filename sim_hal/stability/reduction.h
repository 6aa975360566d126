/* From a whole arm, or a beam, to one degree of freedom, and what that leaves out. */
#ifndef SIM_HAL_STABILITY_REDUCTION_H
#define SIM_HAL_STABILITY_REDUCTION_H

#include <complex>
#include <optional>
#include <vector>

#include "../../hal/rig/beam.h"
#include "../arm/free_swing.h"
#include "arm_loop.h"

namespace berth
{

struct stable_range {
    double from;
    double to;
};

/* Up to where the loop is stable, from the least on that was looked at; 0: it is unstable there; nothing: as far as
 * was looked. */
struct loop_limits {
    std::optional<double> reduced;
    std::optional<double> full;
    double looked_from;
    double looked_to;
    /* Of the dead time all that were found: the loop may be stable again beyond. One that is narrower than the steps
     * in which it was looked may be passed over. */
    std::vector<stable_range> reduced_ranges;
    std::vector<stable_range> full_ranges;
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
    loop_limits object_stiffness; /* times the object's own */
    /* The robot's, ms. Further axes have theirs as much longer or shorter. */
    loop_limits dead_time_ms;
};

/* A beam reduced to its first mode, at the manipulator of one degree of freedom. */
struct object_reduction {
    std::vector<beam_mode> modes;         /* the first is the object of one degree of freedom */
    double compliance_share;              /* what the first mode has of the compliance of all */
    std::optional<arm_mode> arm_at_start; /* the manipulator, of a rig with an arm */
    /* With the manipulator fixed to it, without dead time: the first that swings. */
    swing coupled_reduced;
    swing coupled_full;
    /* In the rig's loop. */
    arm_loop_growth loop_reduced;
    arm_loop_growth loop_full;
    /* As of an arm. */
    loop_limits object_stiffness;
    loop_limits dead_time_ms;
};

/* The pose where the arm starts, along the rig's direction, the tool as free across it as in a run. */
reduction_choice choice_at_start(const rig &rig, const arm_config &arm);

/* The mode that stands for a rig's arm where it starts; nothing for a rig without one. Throws nothing_springy. */
std::optional<arm_mode> arm_at_start(const rig &rig);

/* Of a rig whose object is a beam; of a whole arm, its reduction at its start. Throws input_error for a rig without
 * one-period map. */
object_reduction reduce_object(const rig &rig);

/* Throws input_error for a rig without one-period map, or a pose at which no spring of the arm moves its tool along
 * the direction. */
reduction reduce(const rig &rig, const arm_config &arm, const reduction_choice &choice);

} // namespace berth

#endif
