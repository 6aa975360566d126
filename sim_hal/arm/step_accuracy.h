/* How accurate an arm's steps are in the loop, by halving them: cheap enough to stand beside the verdict of every
 * run. */
#ifndef SIM_HAL_ARM_STEP_ACCURACY_H
#define SIM_HAL_ARM_STEP_ACCURACY_H

#include <optional>
#include <string>

#include "../../hal/rig/rig.h"

namespace berth
{

constexpr double usual_repeatability_m = 60e-6; /* of a robot of this size: makers state 30 to 100 um */

/* Of the tool in the berthing manoeuvre of berthing.h, with the rig's arm, its first mode of the object, and the
 * force as the loop takes it. It is about the steps, not about the run's own motion. */
struct step_accuracy {
    double step_ms;
    std::optional<double> tool_m; /* largest error; none: not known. Infinite: the steps blow up */
    std::string why_unknown;

    /* None: not known. */
    std::optional<bool> is_accurate() const;
};

/* Twice the distance to the same in half the steps: the error itself where it goes with the step, half as much again
 * where it goes with its square (Richardson 1911). Takes two manoeuvres, one of them in half the steps. */
step_accuracy estimate_accuracy(const rig &rig);

/* One sentence for a person; an inaccurate one says what to do. */
std::string accuracy_sentence(const step_accuracy &accuracy, const rig &rig);

} // namespace berth

#endif
