/* What the loss of one setpoint does to what is measured. */
#ifndef SIM_HAL_DIAGNOSIS_SAMPLES_LOSS_TRACE_H
#define SIM_HAL_DIAGNOSIS_SAMPLES_LOSS_TRACE_H

#include <cstddef>
#include <vector>

#include "../replay/block_model.h"

namespace berth
{

/* For 1 m of way that the robot lacks in the tick of the setpoint: from the tick after it on. */
struct loss_trace {
    std::size_t first; /* ticks after the setpoint */
    std::vector<double> values;
    double square = 0.0;
};

/* Of all that comes after the way of the setpoints (driven_path.h). No values where the record has no motion. */
loss_trace trace_of_loss(const block_model &model, const rig &rig);

} // namespace berth

#endif
