/* Advice on a loop that is judged by runs: play, friction, a drive's limits, and compensations without eigenvalues.
 */
#ifndef SIM_HAL_RUN_ADVICE_H
#define SIM_HAL_RUN_ADVICE_H

#include "advice.h"

namespace berth
{

/* Effects of size, or a compensation without eigenvalues: runs without noise tell what becomes of a swing. */
bool is_told_by_runs(const rig &rig);

/* Of such a rig that is not stable. Each cure is run, and run again cure_safety further. A drive's limits are left
 * out at first, as what is small enough meets none; then steps of a few factors are tried. Takes some thirty runs.
 */
stability_advice advise_by_runs(const rig &rig);

} // namespace berth

#endif
