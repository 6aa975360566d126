/* How wrong fixed steps are: the berthing manoeuvre by every integrator in steps of many lengths, against CVODE. */
#ifndef SIM_HAL_ARM_ACCURACY_H
#define SIM_HAL_ARM_ACCURACY_H

#include <array>
#include <functional>
#include <optional>
#include <vector>

#include "berthing.h"

namespace berth
{

/* ms; all divide the command period. */
constexpr std::array accuracy_steps_ms = {0.1, 0.2, 0.5, 1.0, 2.0, 2.5, 5.0, 10.0, 20.0};

/* Largest errors at the ends of the command periods. Infinite where the steps have blown up. */
struct accuracy_row {
    arm_integrator integrator;
    berthing_force force;
    double step_ms;
    std::int64_t substeps;
    double tool_m;
    double force_N; /* nothing of a step's own where the force is that of the truth: then 0 */
    double energy_J;
};

struct accuracy {
    std::vector<accuracy_row> rows;
    double
        truth_m; /* the truth's own error: by how much the tool differs where the tolerance is ten times as large */
    int events;  /* touches and releases at which the truth was stopped and started again */
    double force_N; /* the largest of the truth */
    double energy_J;
    std::vector<momentum_drift> drifts; /* in the arm's own steps, by integrator; none on a held base */
    std::optional<accuracy_row> enough; /* with the arm's own integrator: the fewest substeps of those tried, more
                                           than it has, that keep the tool within the bound */
};

/* Which step is asked about. */
struct accuracy_question {
    double step_ms;    /* one of accuracy_steps_ms */
    double tool_max_m; /* of the integrator alone; beyond, more substeps are tried */
};

/* The row of these, which is there. */
const accuracy_row &row_at(const accuracy &found, arm_integrator integrator, berthing_force force, double step_ms,
                           std::int64_t substeps);

/* Rows for all steps without substeps, then, for an arm that has some, those of the step that is asked about in so
 * many. `tell_progress` hears the share that is done. */
accuracy find_accuracy(const arm_config &arm, const berthing_plan &plan, const accuracy_question &question,
                       const std::function<void(double share)> &tell_progress);

} // namespace berth

#endif
