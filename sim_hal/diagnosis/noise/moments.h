/* A white error moment by moment: what acts seldom hides in the sum over a record. */
#ifndef SIM_HAL_DIAGNOSIS_NOISE_MOMENTS_H
#define SIM_HAL_DIAGNOSIS_NOISE_MOMENTS_H

#include <cstddef>
#include <vector>

namespace berth
{

/* Share of half seconds in which the white error is well above the floor. */
double share_of_bad_moments(const std::vector<double> &white, double period_s);

/* Tenths of a second whose sum of squares no noise reaches: two of them, or one far beyond. Normal noise of any
 * colour stays within 6 standard deviations of that sum in a record of minutes. */
bool has_bursts(const std::vector<double> &white, double period_s);

} // namespace berth

#endif
