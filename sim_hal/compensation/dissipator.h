/* A dissipator designed from eigenvalues: the least damping with which the loop keeps a margin. */
#ifndef SIM_HAL_COMPENSATION_DISSIPATOR_H
#define SIM_HAL_COMPENSATION_DISSIPATOR_H

#include <optional>

#include "../../hal/rig/rig.h"

namespace berth
{

/* How much worse the loop may be and still be stable. */
struct loop_margin {
    double dead_time_ms = 0.0; /* longer */
    double gain_dB = 0.0;      /* of the force: larger */
};

/* dissipation.damping_N_s_per_m, to 1 %; 0: the loop has the margin by itself; nothing: no damping gives it, as with
 * a mode that more damping, a tick late, drives. Throws input_error for rigs without eigenvalues. */
std::optional<double> least_damping(const rig &rig, const loop_margin &margin);

} // namespace berth

#endif
