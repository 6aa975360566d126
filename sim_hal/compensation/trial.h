/* One run of the loop beside what it should have been without dead time. */
#ifndef SIM_HAL_COMPENSATION_TRIAL_H
#define SIM_HAL_COMPENSATION_TRIAL_H

#include "../../hal/rig/rig.h"

namespace berth
{

/* What becomes of a swing. */
enum class fate {
    decays,
    lasts,   /* as a limit cycle does; where noise keeps a swing going, its heights scatter, and this with them */
    diverges /* or a fault has ended it */
};

struct trial_result {
    bool ran;            /* the supervisor let it run to the end, no fault stopped it */
    bool is_bounded;     /* it swings no further than it should, twice over */
    double swing_m;      /* rms of the truth about its mean */
    double error;        /* rms of the distance to the truth, as a share of the truth's rms about its mean */
    double robot_error;  /* the same of the robot's distance to where the manipulator is now */
    double peak_error_m; /* largest distance of the manipulator to the truth */
    double peak_force_N; /* measured */
    long limited_ticks;  /* in which a limit acted */
    double growth_per_s; /* of the swing's height, in the second half of the run, or until it is gone */
    bool has_growth;     /* no: a fault ended it before it grew; its growth is one over the duration then */
    berth::fate fate;
};

/* Runs firmware and simulated rig for `duration_s` after the release, and the coupled system with the same commands
 * beside them. */
trial_result run_trial(const rig &rig, double duration_s);

} // namespace berth

#endif
