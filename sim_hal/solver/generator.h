/* The plant as a linear system with the reference line as its input. */
#ifndef SIM_HAL_SOLVER_GENERATOR_H
#define SIM_HAL_SOLVER_GENERATOR_H

#include "../plant/plant.h"

namespace berth
{

/* Inputs: u at the start of the interval, its slope, and 1 (the surface's position enters as a constant). */
constexpr int plant_input_count = 3;

/* d/dt (state, u, u', 1) as a matrix; its exponential advances them together.
 *
 * The right-hand side is affine in (state, u, u') within a contact mode: its matrix is found by asking it for unit
 * vectors, so that the equations stand in one place only. */
template <typename state_type>
Eigen::MatrixXd make_generator(const plant &plant, contact_mode mode);

} // namespace berth

#endif
