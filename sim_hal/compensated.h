/* How far a loop with compensation of the dead time may go until it is unstable. The hardware changes, and the
 * firmware goes on with what it was told: that is what a margin is for.
 *
 * Linear methods have eigenvalues. Identification, an inverse that adapts, tank and passivity have none, nor has a
 * loop with play, friction or another effect of size, or one that changes from tick to tick: it is run from a
 * deflection for 20 s, a tool held to the material, and the growth of its swing is bisected, without noise and
 * events. Play may keep a small part of a swing alive: such a loop runs on for up to 100 s, until it is at rest. */
#ifndef SIM_HAL_COMPENSATED_H
#define SIM_HAL_COMPENSATED_H

#include <optional>
#include <string_view>
#include <vector>

#include "../hal/rig/rig.h"
#include "verdict.h"

namespace berth
{

/* Of each run. */
constexpr double compensated_run_s = 20.0;

struct compensated_growth {
    stability_verdict verdict; /* its growth is missing where a swing neither grows nor decays */
    bool is_measured;          /* by a run; else the eigenvalues' */

    bool is_stable() const { return verdict.is_stable == std::optional<bool>(true); }
};

/* `amplitude_m`: of the run's deflection; nothing: the rig's own; 0: small motions, without effects of size. Throws
 * input_error where the loop can neither be run nor has eigenvalues. */
compensated_growth growth_of_compensated(const rig &rig, std::optional<double> amplitude_m = {});

/* The same as a prediction. */
growth_prediction predict_compensated(const rig &rig, std::optional<double> amplitude_m = {});
/* Play, friction, a dead band, or a drive with limits: what becomes of a swing depends on its size, which
 * eigenvalues do not know. Of a manipulator of one degree of freedom. */
bool is_judged_by_runs(const rig &rig);

/* As growth_of_compensated(); of a drive with limits also up to which swing it is stable, by harmonic balance. */
stability_verdict verdict_by_runs(const rig &rig, std::optional<double> amplitude_m = {});

struct compensated_limit {
    std::string_view key; /* of the hardware, in the rig file */
    double value;         /* the rig's own */
    std::optional<double> below;
    std::optional<double> above;
};

/* The nearest values at which a stable loop is one no more, or an unstable one becomes it, within a factor of 10
 * either way, in steps of 15 %: a narrower interval may be overlooked. Of dead time, mass and stiffness of the
 * object. */
std::vector<compensated_limit> limits_of_compensated(const rig &rig, std::optional<double> amplitude_m = {});

/* By how much the robot's dead time, that of all its axes, may grow; empty of a loop that is not stable. */
stability_margin margin_of_compensated(const rig &rig, std::optional<double> amplitude_m = {});

/* The same where the limits are known. */
stability_margin margin_of_compensated(const rig &rig, const compensated_growth &own,
                                       const std::vector<compensated_limit> &limits);

} // namespace berth

#endif
