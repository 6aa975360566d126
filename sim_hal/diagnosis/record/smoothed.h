/* A measured motion without the noise of its sensor, as far as the motion itself allows.
 *
 * The posterior mean under a velocity that wanders (a smoothing spline: Wahba, J. R. Stat. Soc. B 1978), by a Kalman
 * filter and the pass back (Rauch, Tung & Striebel, AIAA J. 1965). How much the velocity wanders is estimated from
 * the record, and anew about each row: a motion with rests is smooth in these and quick between them. Friction is
 * driven by the way that a motion goes there and back, and noise goes a long way at rest. */
#ifndef SIM_HAL_DIAGNOSIS_RECORD_SMOOTHED_H
#define SIM_HAL_DIAGNOSIS_RECORD_SMOOTHED_H

#include "record.h"

namespace berth
{

/* `noise`: standard deviation of the column, in its unit, from row to row; 0: as it is. */
std::vector<double> smoothed(const record &data, const std::vector<double> &column, double noise);

} // namespace berth

#endif
