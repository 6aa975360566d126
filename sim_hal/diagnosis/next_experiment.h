/* What to measure next, so that causes which a record cannot tell apart come apart. */
#ifndef SIM_HAL_DIAGNOSIS_NEXT_EXPERIMENT_H
#define SIM_HAL_DIAGNOSIS_NEXT_EXPERIMENT_H

#include "detectable.h"
#include "experiment.h"
#include "search/block_diagnosis.h"

namespace berth
{

struct next_experiment {
    std::vector<std::string> rivals; /* effects; "nothing": the re-tuned rig */
    std::optional<excitation> proposed;
    double predicted_gap = 0.0; /* expected difference of BIC, of the pair of rivals that is hardest to tell apart */
    std::string why;
    std::string calibration; /* what else would decide; empty: not needed */
    berth::rig rig;          /* that the prediction was made with */
};

/* For one_of, unknown and partly_explained: simulates candidate excitations with every rival and takes that in which
 * the rivals, re-fitted, stay farthest apart. Without rivals: what would show of which kind the rest is. */
next_experiment tell_rivals_apart(const block_diagnosis &found, const record &shown, const rig &given);

/* For nothing_detectable: the excitation that would show the smallest effects. `sizes`: what `shown` would have
 * shown in the block of `found`. */
std::optional<next_experiment> show_more(const block_diagnosis &found, const std::vector<detectable_size> &sizes,
                                         const record &shown, const rig &given);

} // namespace berth

#endif
