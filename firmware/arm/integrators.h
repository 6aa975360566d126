/* One fixed step of an arm, the input held. */
#ifndef FIRMWARE_ARM_INTEGRATORS_H
#define FIRMWARE_ARM_INTEGRATORS_H

#include "dynamics.h"

namespace berth
{

/* `offset_s`: from the instant for which the input's commands hold to the start of the step.
 *
 * semi-implicit Euler   order 1; one evaluation; stable while w h < 2
 * RK4                   order 4; four evaluations; stable while w h < 2.8
 * implicit midpoint     order 2; two evaluations; implicit in springs, dampers and servos, of any stiffness; what
 * turns with the arm's shape is taken at the middle that the first evaluation leads to
 *
 * `at_limit`, if any: takes on a bit for each joint whose motor was at its torque limit in what the step was made of
 * (implicit midpoint: its second evaluation), and keeps those that it has. */
template <class Space>
chain_state<Space> advanced(const chain<Space> &chain, const chain_state<Space> &state,
                            const chain_input<Space> &input, arm_integrator integrator, double step_s,
                            double offset_s, std::uint32_t *at_limit = nullptr);

} // namespace berth

#endif
