/* The step that a signal's values are whole numbers of: of a converter, an encoder, a wire, a printed decimal. */
#ifndef SIM_HAL_DIAGNOSIS_NOISE_LATTICE_STEP_H
#define SIM_HAL_DIAGNOSIS_NOISE_LATTICE_STEP_H

#include <vector>

namespace berth
{

/* In the signal's unit; 0: there is none. One value in a hundred may lie off the steps, however fine these are; of
 * steps that are coarse enough for a signal to rest on, one in twenty, and noise may be added to all of them, of
 * less than a tenth of the step. */
double lattice_step(const std::vector<double> &values);

} // namespace berth

#endif
