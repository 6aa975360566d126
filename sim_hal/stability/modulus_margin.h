/* How far a stable loop is from one that starts to swing. */
#ifndef SIM_HAL_STABILITY_MODULUS_MARGIN_H
#define SIM_HAL_STABILITY_MODULUS_MARGIN_H

#include "loop_equation.h"

namespace berth
{

/* The modulus margin: the smallest |1 + L| over all frequencies up to half the rate, L the loop cut open where the
 * force goes into the manipulator (its inverse is the largest sensitivity; Garcia, Karimi & Longchamp 2004). 1 + L =
 * F/A of the loop's equation. 0: about to swing; of a loop with nothing fed back 1. Means something for a stable
 * loop only. */
double modulus_margin(const loop_equation &equation);

} // namespace berth

#endif
