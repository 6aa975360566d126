/* A manipulator's parameters straight from its equation of motion: where a fit of its replay may begin. */
#ifndef SIM_HAL_DIAGNOSIS_FIT_MANIPULATOR_REGRESSION_H
#define SIM_HAL_DIAGNOSIS_FIT_MANIPULATOR_REGRESSION_H

#include <vector>

#include "fit.h"

namespace berth
{

/* Dry friction makes a replay turn at other moments with every other size, so that its error has many minima; the
 * equation of motion is linear in all sizes. Its weak form, integrated with smooth functions that end in zero, has
 * no derivative of what was measured (Messenger & Bortz, Weak SINDy, J. Comput. Phys. 2021); stretches in which the
 * motion may turn are left out. Least squares over the rows of the fit, with the base parameters' priors.
 *
 * Rigs with `effect` beside those `found`, all sizes as the equation has them: from shorter and longer stretches,
 * with dry friction that builds up as in `incumbent`, at once, or over short ways. None of another block, of a
 * manipulator without a spring, where a size does not stand in the equation, or where what was measured does not
 * decide. */
std::vector<rig> regressed_starts(const block_model &model, const fit_result &incumbent,
                                  const std::vector<const effect *> &found, const effect &effect);

/* The parameters of a fit that begins there: bounds about the sizes in `start`. */
std::vector<free_parameter> parameters_about(const rig &start, const fit_result &incumbent,
                                             const std::vector<const effect *> &found, const effect &effect);

} // namespace berth

#endif
