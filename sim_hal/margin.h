/* How far a stable loop is from one that swings. */
#ifndef SIM_HAL_MARGIN_H
#define SIM_HAL_MARGIN_H

#include <optional>
#include <string>
#include <vector>

#include "../hal/rig/rig.h"
#include "stability/limits.h"

namespace berth
{

struct stability_margin {
    std::optional<double> dead_time_ms; /* by which the robot's dead time, that of all its axes, may grow */
    bool is_dead_time_open = false;     /* by more: that is as far as was searched */
    std::optional<double> modulus;      /* smallest |1 + L|, see modulus_margin.h; a plain loop alone has one */
    bool is_unlimited = false;          /* nothing feeds back: any dead time will do */
    std::string note;                   /* what the figure rests on, or why there is none; empty: eigenvalues */

    /* Dead times beyond that limit at which the loop is stable again, as far as was searched. */
    std::vector<stable_interval> stable_again_ms = {};
    bool is_again_open = false; /* the last of them goes on where the search ended */
};

/* Of a loop that is stable; empty of one that is not. With compensation, the robot's dead time grows and the
 * firmware's settings stay as they are. What changes from tick to tick is left out, and the note says so. Takes 20 s
 * of simulated time some thirty times where a compensation has no eigenvalues, and where the size of the motion
 * matters, see is_judged_by_runs(): from the rig's own start, or let go this far from rest. */
stability_margin margin_of(const rig &rig, std::optional<double> amplitude_m = {});

} // namespace berth

#endif
