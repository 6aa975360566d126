/* What the loop's small motions say of a run's growth, beside what is measured. */
#ifndef SIM_HAL_CLI_RUN_PREDICTION_H
#define SIM_HAL_CLI_RUN_PREDICTION_H

#include <optional>
#include <string>

#include "../../hal/rig/rig.h"

namespace berth
{

struct growth_prediction {
    std::optional<double> growth_per_s;
    std::string why_not; /* where there is none */
};

/* From the eigenvalues, or the Lyapunov exponent, of the loop without noise and limits. */
growth_prediction predict_growth(const rig &rig);

} // namespace berth

#endif
